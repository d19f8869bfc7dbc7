"""Rule: faces refer to points that exist, and every attribute has a value for each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pxr import UsdGeom

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.read_shape import topology_fault
from gate.subject.values import TIME, at, integers, rows
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-mesh-topology",
    "Faces or attributes of a mesh do not fit its points",
    "Renderers drop the mesh, show noise or read foreign memory.",
    "export the mesh again",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per mesh with impossible faces, and per primvar or normal array of the wrong length."""
    for prim in subject.meshes:
        points = len(rows(prim, "points", 3))
        counts, indices = integers(prim, "faceVertexCounts"), integers(prim, "faceVertexIndices")
        fault = topology_fault(points, counts, indices)
        if fault:
            yield finding(CODE, fault, where=at(prim))
            continue
        sizes = {
            "constant": 1,
            "uniform": len(counts),
            "vertex": points,
            "varying": points,
            "faceVarying": len(indices),
        }
        for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues():
            yield from _primvar(prim, primvar, sizes)
        normals = rows(prim, "normals", 3)
        expected = sizes.get(str(UsdGeom.Mesh(prim).GetNormalsInterpolation()))
        if len(normals) and len(normals) != expected:
            yield finding(CODE, "normals has the wrong length", where=at(prim), value=len(normals), bound=expected)


def _primvar(prim: Any, primvar: Any, sizes: dict[str, int]) -> Iterator[Diagnostic]:
    name, interpolation, value = primvar.GetPrimvarName(), str(primvar.GetInterpolation()), primvar.Get(TIME)
    if interpolation not in sizes:
        headline = f"primvar {name} has an unknown interpolation"
        yield finding(CODE, headline, where=at(prim), value=interpolation, bound=", ".join(sizes))
        return
    if value is None:
        return
    expected = sizes[interpolation]
    length = len(value) if primvar.GetTypeName().isArray else 1
    if primvar.IsIndexed():
        picks = primvar.GetIndices(TIME)
        highest, length = max(picks, default=-1), len(picks)
        if highest >= len(value) or min(picks, default=0) < 0:
            headline = f"the indices of primvar {name} leave its values"
            yield finding(CODE, headline, where=at(prim), value=highest, bound=len(value) - 1)
    if length != expected * primvar.GetElementSize() and expected != 1:
        headline = f"primvar {name} has the wrong length"
        yield finding(CODE, headline, where=at(prim), value=length, bound=expected)


RULE = Rule(
    CODE, "indices within the points; arrays as long as their interpolation asks", "UsdGeomMesh, UsdGeomPrimvar", check
)
