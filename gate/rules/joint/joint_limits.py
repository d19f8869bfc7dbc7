"""Rule: joint limits are stated and ordered."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Joint, Subject
from gate.subject.joint import ONE_DOF_KINDS
from gate.subject.limits import axis_limits
from gate.subject.values import at, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-joint-limits",
    "Joint limits are inverted or missing",
    "The joint locks, or moves freely, depending on the engine.",
    "state lower <= upper, in degrees for hinges and metres for slides",
)
CONE_DEG = 180.0


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per joint whose limits are inverted, no numbers, or missing.

    A revolute joint may turn for ever, if its limits are authored as infinite; a prismatic one cannot.
    """
    for joint in subject.joints:
        if joint.kind in ONE_DOF_KINDS:
            yield from _ordered(joint)
            yield from _missing(subject, joint)
        elif joint.kind == "spherical":
            for index in (0, 1):
                cone = number(joint.prim, f"physics:coneAngle{index}Limit", -1.0)
                if not (cone == -1.0 or 0.0 <= cone <= CONE_DEG):  # -1 means free
                    headline = f"coneAngle{index}Limit is no angle"
                    yield finding(CODE, headline, where=at(joint.prim), value=cone, bound=CONE_DEG, unit="deg")
        elif joint.kind == "distance":
            least, most = (number(joint.prim, f"physics:{name}Distance", -1.0) for name in ("min", "max"))
            if np.isnan(least) or np.isnan(most) or (least > most >= 0.0):
                headline = "the least distance is above the largest"
                yield finding(CODE, headline, where=at(joint.prim), value=least, bound=most, unit="m")
        for axis, (low, high) in axis_limits(joint.prim).items():
            # On a generic joint low > high locks the axis (UsdPhysicsLimitAPI); elsewhere nothing reads it.
            if np.isnan(low) or np.isnan(high):
                yield finding(CODE, f"the limits of {axis} are no numbers", where=at(joint.prim), value=low, bound=high)


def _ordered(joint: Joint) -> Iterator[Diagnostic]:
    lower, upper = joint.limits
    if not lower <= upper:
        nan = np.isnan(lower) or np.isnan(upper)
        headline = "a joint limit is no number" if nan else "the lower joint limit is above the upper one"
        yield finding(CODE, headline, where=at(joint.prim), value=lower, bound=upper, unit=joint.unit)
    elif lower == np.inf or upper == -np.inf:
        headline = "a joint limit is infinite on the wrong side"
        yield finding(CODE, headline, where=at(joint.prim), value=lower, bound=upper, unit=joint.unit)


def _missing(subject: Subject, joint: Joint) -> Iterator[Diagnostic]:
    endless = [side for side, limit in zip(("lower", "upper"), joint.limits, strict=True) if np.isinf(limit)]
    unstated = [side for side, stated in zip(("lower", "upper"), joint.stated, strict=True) if not stated]
    if joint.kind == "prismatic" and endless:
        headline = f"the {' and '.join(endless)} limit of a sliding joint is missing"
        yield finding(CODE, headline, where=at(joint.prim), unit="m", severity=subject.suspect_severity)
    elif len(endless) == 1:
        headline = f"the {endless[0]} limit is missing, the other is there"
        yield finding(CODE, headline, where=at(joint.prim), unit="deg", severity=subject.suspect_severity)
    elif unstated and (subject.released or len(unstated) == 1):
        headline = "the limits are not stated; if the joint turns for ever, state -inf and inf"
        severity = subject.suspect_severity if subject.released else Severity.INFO
        yield finding(CODE, headline, where=at(joint.prim), unit="deg", severity=severity)


RULE = Rule(
    CODE,
    "lower <= upper; both stated; sliding joints finite; cone angles 0 .. 180 deg",
    "UsdPhysicsRevoluteJoint, UsdPhysicsPrismaticJoint; SimReady JT",
    check,
)
