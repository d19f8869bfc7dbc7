"""Shader networks: shader ids, constant input values, the shader connected to an input."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import UsdShade

from gate.subject.values import TIME, text
from schemas.arrays import FloatArray


def shader_id(prim: Any) -> str:
    """`info:id`, or the name of the MDL material; "" when neither is stated."""
    return text(prim, "info:id") or text(prim, "info:mdl:sourceAsset:subIdentifier")


def is_material_x(identifier: str) -> bool:
    """Whether a shader id is that of a MaterialX node definition."""
    return identifier.startswith("ND_")


def is_mdl(prim: Any) -> bool:
    """Whether a shader's implementation is a material of an MDL module."""
    return text(prim, "info:implementationSource") == "sourceAsset" and prim.HasAttribute("info:mdl:sourceAsset")


def constant_value(shader_input: Any) -> FloatArray | None:
    """(k,) the number or colour an input has, also through the material's interface; None when a shader feeds it."""
    attributes = UsdShade.Utils.GetValueProducingAttributes(shader_input)
    if len(attributes) != 1 or attributes[0].GetName().startswith("outputs:"):
        return None
    return _numbers(attributes[0].Get(TIME))


def own_value(shader_input: Any) -> FloatArray | None:
    """(k,) the value authored at the input itself, whatever is connected."""
    return _numbers(shader_input.GetAttr().Get(TIME))


def _numbers(value: Any) -> FloatArray | None:
    try:
        return None if value is None else np.asarray(value, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        return None


def feeding_shader(shader_input: Any) -> tuple[Any, str] | None:
    """The shader prim and output name that an input reads, also through interfaces; None for a constant."""
    for attribute in UsdShade.Utils.GetValueProducingAttributes(shader_input):
        if attribute.GetName().startswith("outputs:"):
            return attribute.GetPrim(), attribute.GetName().removeprefix("outputs:")
    return None
