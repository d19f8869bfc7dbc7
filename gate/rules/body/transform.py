"""Rule: transforms are finite and invertible."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, format_numbers, quaternion
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-transform",
    "A transform is not finite or flattens its prim",
    "Positions, volumes and normals below it are undefined.",
    "correct the transform operations of the prim and its ancestors",
)
_LEAST_SCALE = 1e-9
_QUATERNION_LENGTH_TOLERANCE = 1e-3


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body, collider or visible mesh whose world transform is NaN, infinite or flattens space, and per
    orientation that is no unit quaternion.
    """
    colliders, surfaces = [c.prim for c in subject.colliders], list(subject.visible_prims)
    prims = {str(prim.GetPath()): prim for prim in [*(b.prim for b in subject.bodies), *colliders, *surfaces]}
    for prim in prims.values():
        matrix = subject.frames.matrix(prim)
        if not np.all(np.isfinite(matrix)):
            yield finding(CODE, "the transform is not finite", where=at(prim), value=format_numbers(matrix[:3, 3]))
            continue
        scale = np.linalg.norm(matrix[:3, :3], axis=0) / subject.frames.meters_per_unit
        if scale.min() < _LEAST_SCALE:
            headline = "the transform flattens the prim"
            yield finding(CODE, headline, where=at(prim), value=format_numbers(scale), bound=_LEAST_SCALE)
    for attribute in subject.attributes:
        if attribute.GetName().startswith("xformOp:orient") and attribute.GetNumTimeSamples() == 0:
            length = float(np.linalg.norm(quaternion(attribute.GetPrim(), attribute.GetName())))
            if not abs(length - 1.0) <= _QUATERNION_LENGTH_TOLERANCE:  # Some readers normalise it, others scale by it.
                headline, where = "an orientation is no unit quaternion", at(attribute.GetPrim())
                yield finding(CODE, headline, where=where, value=length, bound=1.0, severity=subject.suspect_severity)


RULE = Rule(CODE, "finite, scale above 1e-9, orientations of length 1 to 1e-3", "UsdGeomXformable", check)
