"""Rule: the authored `extent` of a mesh equals the bounds of its points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import EXTENT_TOLERANCE, at, format_numbers, rows
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-mesh-extent",
    "The stated bounds of a mesh are not those of its points",
    "Viewers cull and frame by the stated bounds, so that the mesh vanishes.",
    "recompute the extent from the points",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per mesh whose `extent` is off by more than 1 % of its size; viewers and culling trust it blindly."""
    for prim in subject.meshes:
        points, extent = rows(prim, "points", 3), rows(prim, "extent", 3)
        if len(extent) == 0 or len(points) == 0 or not np.all(np.isfinite(points)):
            continue
        bounds = np.stack([points.min(axis=0), points.max(axis=0)])
        tolerance = EXTENT_TOLERANCE * float(np.linalg.norm(bounds[1] - bounds[0]))
        if extent.shape != (2, 3) or not float(np.abs(extent - bounds).max()) <= tolerance:
            yield finding(
                CODE,
                "the stated extent is not that of the points",
                where=at(prim),
                value=format_numbers(extent),
                bound=format_numbers(bounds),
                severity=subject.suspect_severity,
            )


RULE = Rule(CODE, "bounds of the points, to 1 % of the diagonal", "UsdGeomBoundable; SimReady VG.002", check)
