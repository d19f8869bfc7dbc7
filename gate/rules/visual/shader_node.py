"""Rule: MaterialX nodes and MDL materials are ones that exist, with inputs that they have, of the right types."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final

from pxr import UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.shading import is_material_x, is_mdl, shader_id
from gate.subject.values import at, raw
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-shader-node",
    "A shader of MaterialX or MDL is unknown, or has an input that it does not take",
    "The renderer that prefers this shader draws the surface black, or without the value.",
    "use the node definitions of MaterialX 1.39 and the parameters of OmniPBR, OmniGlass or OmniPBR_ClearCoat",
)
# Types of MaterialX -> USD types that hold them, by their names in `Sdf.ValueTypeNames`.
USD_TYPES: Final = {
    "float": ("float",),
    "integer": ("int",),
    "boolean": ("bool",),
    "color3": ("color3f", "float3"),
    "color4": ("color4f", "float4"),
    "vector2": ("float2", "texCoord2f"),
    "vector3": ("float3", "vector3f", "normal3f", "point3f", "color3f"),
    "string": ("string", "token"),
    "filename": ("asset",),
}


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per node of no known kind in a package, and per input that the kind lacks or that has another type.

    Other files may use any node of MaterialX and any MDL module; only what is known here is judged. In a package an MDL
    module must be one of its files: a bare name is found on the search path of some renderers only.
    """
    for prim in subject.shaders:
        mdl = is_mdl(prim)
        if not mdl and not is_material_x(shader_id(prim)):
            continue
        inputs = shader_inputs().get(shader_id(prim))
        if mdl and subject.released and not _resolved(prim):
            headline, value = "the MDL module is no file of the package", str(raw(prim, "info:mdl:sourceAsset"))
            yield finding(CODE, headline, where=at(prim), value=value)
        if inputs is not None:
            yield from _inputs(subject, prim, inputs)
        elif subject.released:
            yield finding(CODE, "the shader is of no known kind", where=at(prim), value=shader_id(prim))


@cache
def shader_inputs() -> dict[str, dict[str, str]]:
    """Shader id -> input -> its type as MaterialX calls it, from `shader_inputs.csv`."""
    table: dict[str, dict[str, str]] = {}
    with Path(__file__).with_name("shader_inputs.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            table.setdefault(row["shader"], {})[row["input"]] = row["type"]
    return table


def _inputs(subject: Subject, prim: Any, inputs: dict[str, str]) -> Iterator[Diagnostic]:
    for port in UsdShade.Shader(prim).GetInputs():
        name, kind = port.GetBaseName(), str(port.GetTypeName())
        if name not in inputs:
            headline = f"{shader_id(prim)} has no input {name}"
            yield finding(CODE, headline, where=at(prim), value=name, severity=subject.suspect_severity)
        elif kind not in USD_TYPES[inputs[name]]:
            headline, bound = f"the input {name} has the wrong type", " or ".join(USD_TYPES[inputs[name]])
            yield finding(CODE, headline, where=at(prim), value=kind, bound=bound, severity=subject.suspect_severity)


def _resolved(prim: Any) -> bool:
    module = raw(prim, "info:mdl:sourceAsset")
    return bool(getattr(module, "resolvedPath", ""))


RULE = Rule(
    CODE,
    "known nodes and inputs of their types; in a package MDL modules of its own",
    "MaterialX 1.39 node definitions; SimReady VM.PBR.003, VM.BIND.002, NP.008",
    check,
)
