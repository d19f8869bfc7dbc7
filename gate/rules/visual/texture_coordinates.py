"""Rule: a textured mesh has the texture coordinates its material reads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pxr import Usd, UsdGeom, UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.shading import shader_id
from gate.subject.values import TIME, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-texture-coordinates",
    "A textured mesh lacks texture coordinates",
    "The picture shrinks to a single colour.",
    "author the primvar the material reads",
)
# Nodes that read texture coordinates from the mesh -> the input that names the primvar.
READERS = {"UsdPrimvarReader_float2": "varname", "ND_geompropvalue_vector2": "geomprop"}


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per visible mesh that lacks a primvar which its material's readers of coordinates read."""
    primvars_by_material: dict[str, set[str]] = {}
    for prim in subject.visible_prims:
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if not material:
            continue
        path = str(material.GetPath())
        if path not in primvars_by_material:
            primvars_by_material[path] = _names(material.GetPrim())
        for name in sorted(primvars_by_material[path]):
            primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
            if not primvar or not primvar.HasValue():
                headline = f"the mesh lacks primvar {name}, which its material reads"
                severity = Severity.WARNING  # Sources come like that; the surface keeps one colour of its picture.
                yield finding(CODE, headline, where=at(prim), value="absent", bound=name, severity=severity)


def _names(material: Any) -> set[str]:
    """Primvars read by the texture-coordinate readers of a material."""
    names: set[str] = set()
    for prim in Usd.PrimRange(material, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdShade.Shader) and shader_id(prim) in READERS:
            attributes = UsdShade.Utils.GetValueProducingAttributes(
                UsdShade.Shader(prim).GetInput(READERS[shader_id(prim)])
            )
            names.update(str(value) for a in attributes if (value := a.Get(TIME)))
    return names


RULE = Rule(
    CODE,
    "every primvar that the bound material reads",
    "UsdPreviewSurface specification: UsdPrimvarReader; MaterialX: geompropvalue",
    check,
)
