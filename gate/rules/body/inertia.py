"""Rule: the principal moments are those of a possible mass distribution (triangle inequality)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import UsdPhysics

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, format_numbers, quaternion, vector
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-inertia",
    "The moments of inertia belong to no real body",
    "Engines become unstable or replace the tensor by their own.",
    "recompute the principal moments and axes from the solid",
)
_PRINCIPAL_TOLERANCE = 1e-4  # Moments and axes are stored in single precision.


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body with a moment <= 0, with `I1 + I2 < I3`, or whose axes are no unit quaternion.

    All zeros mean "not stated" (UsdPhysicsMassAPI), which only a released package may not leave to the engine.
    """
    for body in subject.active_bodies:
        if not body.prim.HasAPI(UsdPhysics.MassAPI):
            continue  # Reported by the mass rule.
        moments = np.sort(vector(body.prim, "physics:diagonalInertia", (0.0, 0.0, 0.0)))
        quat_wxyz = quaternion(body.prim, "physics:principalAxes")
        if not np.any(moments) and not np.any(quat_wxyz):
            if subject.released:
                yield finding(CODE, "the body has no inertia", where=at(body.prim), value=format_numbers(moments))
            continue
        if np.any(moments) or subject.released:
            yield from _moments(body.prim, moments)
        length = float(np.linalg.norm(quat_wxyz))
        if length != 0.0 or subject.released:
            yield from _axes(body.prim, length)


def _moments(prim: Any, moments: np.ndarray) -> Iterator[Diagnostic]:
    where = at(prim)
    if not np.all(np.isfinite(moments)) or moments[0] <= 0.0:
        headline = "a principal moment of inertia is not positive"
        yield finding(CODE, headline, where=where, value=format_numbers(moments), bound=0.0, unit="kg m2")
    elif moments[0] + moments[1] < moments[2] * (1.0 - _PRINCIPAL_TOLERANCE):
        headline = "the moments of inertia break the triangle inequality"
        largest, others = float(moments[2]), float(moments[0] + moments[1])
        yield finding(CODE, headline, where=where, value=largest, bound=others, unit="kg m2")


def _axes(prim: Any, length: float) -> Iterator[Diagnostic]:
    if not abs(length - 1.0) <= 10.0 * _PRINCIPAL_TOLERANCE:
        headline = "the principal axes are no unit quaternion"
        yield finding(CODE, headline, where=at(prim), value=length, bound=1.0)


RULE = Rule(CODE, "moments > 0, I1 + I2 >= I3, |q| = 1 to 1e-3", "rigid-body mechanics; UsdPhysicsMassAPI", check)
