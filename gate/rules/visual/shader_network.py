"""Rule: shader networks are complete: surface output, shader ids, connections."""

from __future__ import annotations

from collections.abc import Iterator

from pxr import UsdShade

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.shading import shader_id
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-shader-network",
    "A shader network is incomplete",
    "The material is drawn black or not at all.",
    "connect the surface output, name every shader's id, and connect only to what exists",
)
PORTABLE = "UsdPreviewSurface"


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per render material without a surface, per shader without an id, per connection to nothing."""
    bound = _bound(subject)
    for prim in subject.materials:
        material = UsdShade.Material(prim)
        surfaces = [o for o in material.GetSurfaceOutputs() if o.HasConnectedSource()]
        if str(prim.GetPath()) in bound and not surfaces:
            headline = "the material has no surface shader"
            yield finding(CODE, headline, where=at(prim), severity=subject.suspect_severity)
        elif str(prim.GetPath()) in bound and subject.released:
            yield from _portable(material)
    for prim in (*subject.materials, *subject.shaders):
        if prim.IsA(UsdShade.Shader) and not shader_id(prim) and not _is_source(prim):
            yield finding(CODE, "the shader names no implementation", where=at(prim), severity=subject.suspect_severity)
        connectable = UsdShade.ConnectableAPI(prim)
        for port in (*connectable.GetInputs(), *connectable.GetOutputs()):
            for path in port.GetAttr().GetConnections():
                source = subject.stage.GetPrimAtPath(path.GetPrimPath())
                if not source or (not source.GetAttribute(path.name) and not source.IsA(UsdShade.Shader)):
                    headline = f"{port.GetFullName()} is connected to nothing"
                    yield finding(CODE, headline, where=at(prim), value=str(path))


def _portable(material: UsdShade.Material) -> Iterator[Diagnostic]:
    """The surface output without a render context must be a UsdPreviewSurface, which every renderer supports."""
    shader, _, _ = material.ComputeSurfaceSource()
    name = shader_id(shader.GetPrim()) if shader else ""
    if name != PORTABLE:
        headline, where = "the surface shader is none that every renderer knows", at(material.GetPrim())
        yield finding(CODE, headline, where=where, value=name, bound=PORTABLE)


def _bound(subject: Subject) -> set[str]:
    """Paths of the materials that something visible uses."""
    paths: set[str] = set()
    for prim in subject.visible_prims:
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if material:
            paths.add(str(material.GetPath()))
    return paths


def _is_source(prim: UsdShade.Shader) -> bool:
    return any(a.GetName().endswith((":sourceAsset", ":sourceCode")) for a in prim.GetAuthoredAttributes())


RULE = Rule(
    CODE,
    "a connected UsdPreviewSurface; every shader has an id; every connection has a source",
    "UsdShade; SimReady VM.PS.001",
    check,
)
