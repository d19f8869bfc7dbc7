"""Rule: joint axis, local positions and local rotations are valid."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.joint import AXES
from gate.subject.values import at, format_numbers, quaternion, vector
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-joint-axis",
    "A joint frame is no frame",
    "An unknown axis or a quaternion of another length than 1 is read differently by every engine.",
    "use axis X, Y or Z, finite positions and unit quaternions",
)
_AXIS_LENGTH_TOLERANCE = 1e-3


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per axis that is not X, Y or Z, per position that is not finite, per quaternion not of length 1."""
    for joint in subject.joints:
        where = at(joint.prim)
        if joint.axis not in AXES:
            yield finding(CODE, "the axis is none of X, Y, Z", where=where, value=joint.axis, bound="X, Y or Z")
        for index in (0, 1):
            position = vector(joint.prim, f"physics:localPos{index}", (0.0, 0.0, 0.0))
            if not np.all(np.isfinite(position)):
                yield finding(
                    CODE, f"localPos{index} is not finite", where=where, value=format_numbers(position), unit="m"
                )
            length = float(np.linalg.norm(quaternion(joint.prim, f"physics:localRot{index}")))
            if not abs(length - 1.0) <= _AXIS_LENGTH_TOLERANCE:
                yield finding(CODE, f"localRot{index} is no unit quaternion", where=where, value=length, bound=1.0)


RULE = Rule(CODE, "axis X, Y or Z; finite positions; |q| = 1 to 1e-3", "UsdPhysicsJoint", check)
