"""Evaluates UsdShade networks of MaterialX nodes by the definitions of the nodes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pxr import UsdShade

Pixels = dict[str, tuple[float, float, float, float]]  # file name -> the RGBA of every texel, as stored, 0..1


def value_of(port: UsdShade.Input, pixels: Pixels) -> Any:
    """The value of a shader input: a number, an array, or ("normal map", direction, scale), ("primvar", name)."""
    sources = port.GetConnectedSources()[0]
    if not sources:
        value = port.Get()
        return np.array(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
    node = UsdShade.Shader(sources[0].source.GetPrim())
    return _output(node, sources[0].sourceName, pixels)


def placed(port: UsdShade.Input, uv: tuple[float, float]) -> tuple[str, np.ndarray]:
    """The primvar and the coordinates at which the picture upstream of `port` is read for a mesh's (u, v)."""
    sources = port.GetConnectedSources()[0]
    node = UsdShade.Shader(sources[0].source.GetPrim())
    if node.GetShaderId() == "ND_geompropvalue_vector2":
        return node.GetInput("geomprop").Get(), np.array(uv)
    if node.GetShaderId() == "ND_place2d_vector2":
        name, at = placed(node.GetInput("texcoord"), uv)
        x, y = at / np.array(node.GetInput("scale").Get())
        turn = math.radians(node.GetInput("rotate").Get())
        c, s = math.cos(turn), math.sin(turn)
        return name, np.array([c * x + s * y, -s * x + c * y]) - np.array(node.GetInput("offset").Get())
    ports = [node.GetInput("texcoord")] if node.GetInput("file") else [p for p in node.GetInputs() if _connected(p)]
    return placed(ports[0], uv)


def _connected(port: UsdShade.Input) -> bool:
    return bool(port.GetConnectedSources()[0])


def _output(node: UsdShade.Shader, output: str, pixels: Pixels) -> Any:
    kind = node.GetShaderId()
    inputs = {port.GetBaseName(): port for port in node.GetInputs()}

    def at(name: str) -> Any:
        return value_of(inputs[name], pixels)

    if kind.startswith("ND_image_"):
        rgba = np.array(pixels[inputs["file"].Get().path])
        if inputs["file"].GetAttr().GetColorSpace() == "srgb_texture":
            rgb = rgba[:3]
            rgba[:3] = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        return rgba if kind.endswith("color4") else rgba[:3]
    if kind.startswith("ND_separate"):
        return float(at("in")["rgba".index(output.removeprefix("out"))])
    if kind.startswith("ND_multiply"):
        return at("in1") * at("in2")
    if kind.startswith("ND_add"):
        return at("in1") + at("in2")
    if kind == "ND_ifgreatereq_float":
        return at("in1") if at("value1") >= at("value2") else at("in2")
    if kind == "ND_normalmap_float":
        return "normal map", at("in"), at("scale")
    if kind.startswith("ND_geompropvalue"):
        return "primvar", inputs["geomprop"].Get()
    if kind == "ND_rotate3d_vector3":
        return "turned", at("amount")
    raise AssertionError(f"unknown node {kind}")
