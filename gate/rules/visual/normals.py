"""Rule: normals agree with the winding of the faces and have length 1."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import UsdGeom

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.read_shape import topology_fault
from gate.subject.values import at, integers, rows, text
from geom.mesh.polygon_triangulation import triangulate_polygons
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-normals",
    "Normals point inwards or do not have length 1",
    "The surface is lit from the wrong side.",
    "recompute the normals from the faces",
)
LEAST_AGREEMENT = 0.0
LENGTH_TOLERANCE, MOST_OFF = 0.1, 0.01


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per visible mesh whose normals oppose its faces on the whole, or of which over 1 % have another
    length than 1.
    """
    for prim in subject.visible_prims:
        if not prim.IsA(UsdGeom.Mesh):
            continue
        normals, interpolation = _normals(prim)
        if len(normals) == 0 or not np.all(np.isfinite(normals)):
            continue
        lengths = np.linalg.norm(normals, axis=1)
        off = float((np.abs(lengths - 1.0) > LENGTH_TOLERANCE).mean())
        if off > MOST_OFF:
            headline = "normals do not have length 1"
            where, severity = at(prim), subject.suspect_severity
            yield finding(CODE, headline, where=where, value=off, bound=MOST_OFF, severity=severity)
        agreement = _agreement(prim, normals, interpolation)
        if agreement < LEAST_AGREEMENT:
            headline = "normals point against the winding of the faces"
            where, severity = at(prim), subject.suspect_severity
            yield finding(CODE, headline, where=where, value=agreement, bound=LEAST_AGREEMENT, severity=severity)


def _normals(prim: Any) -> tuple[np.ndarray, str]:
    """The values (n, 3), primvar first, flattened, and their interpolation."""
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("normals")
    if primvar and primvar.HasValue():
        values = rows(prim, "primvars:normals", 3)
        picks = integers(prim, "primvars:normals:indices") if primvar.IsIndexed() else None
        if picks is not None and len(picks) and picks.min() >= 0 and picks.max() < len(values):
            values = values[picks]
        return values, str(primvar.GetInterpolation())
    return rows(prim, "normals", 3), str(UsdGeom.Mesh(prim).GetNormalsInterpolation())


def _agreement(prim: Any, normals: np.ndarray, interpolation: str) -> float:
    """Area-weighted mean cosine between faces and normals, -1 .. 1; 1 where lengths do not fit (another rule)."""
    points = rows(prim, "points", 3)
    counts, indices = integers(prim, "faceVertexCounts"), integers(prim, "faceVertexIndices")
    if len(counts) == 0 or topology_fault(len(points), counts, indices) or not np.all(np.isfinite(points)):
        return 1.0
    corners, owner = triangulate_polygons(points, indices, counts)
    picks = {"faceVarying": corners, "vertex": indices[corners], "varying": indices[corners], "uniform": owner[:, None]}
    chosen = picks.get(interpolation)
    if chosen is None or chosen.size == 0 or chosen.max() >= len(normals):
        return 1.0
    a, b, c = np.moveaxis(points[indices[corners]], 1, 0)
    area = np.cross(b - a, c - a)
    if text(prim, "orientation") == UsdGeom.Tokens.leftHanded:
        area = -area
    dots = np.einsum("fi,fki->fk", area, normals[chosen]).mean(axis=1)
    total = float(np.linalg.norm(area, axis=1).sum())
    return float(dots.sum()) / total if total > 0.0 else 1.0


RULE = Rule(CODE, "mean cosine with the faces >= 0; length 1 to 0.1 for 99 %", "SimReady VG.028, VG.029", check)
