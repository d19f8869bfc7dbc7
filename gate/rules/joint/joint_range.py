"""Rule: the range of a joint is that of a real mechanism, in degrees or metres."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Joint, Subject
from gate.subject.body import diagonal, stacked
from gate.subject.joint import ONE_DOF_KINDS
from gate.subject.values import at, format_numbers
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-joint-range",
    "The range of a joint is none a mechanism has",
    "Radians read as degrees make a door that moves by a hair, millimetres as metres a drawer that flies away.",
    "check the unit: USD wants degrees for hinges and stage units for slides",
)
MOST_DEG = 1080.0  # Three turns each way; a valve or screw with more has infinite limits.
RADIANS_LEAST, RADIANS_MOST = 0.7, 2.0 * np.pi * 1.01
SLIDE_ASSET_SIZES = 1.5


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per joint that is locked by its limits, turns or slides absurdly far, or seems to be in radians."""
    clouds = [cloud for b in subject.bodies for cloud in (b.collider_points_W, b.visible_points_W)]
    asset_m = diagonal(stacked(clouds))
    for joint in subject.joints:
        lower, upper = joint.limits
        if joint.kind in ONE_DOF_KINDS and lower <= upper and np.isfinite(upper - lower):
            yield from _range(subject, joint, asset_m)


def _range(subject: Subject, joint: Joint, asset_m: float) -> Iterator[Diagnostic]:
    lower, upper = joint.limits
    where, span, value = at(joint.prim), upper - lower, format_numbers(np.array(joint.limits))
    if span == 0.0:
        headline = "the limits lock the joint; a fixed joint would say so"
        yield finding(CODE, headline, where=where, value=value, unit=joint.unit, severity=subject.suspect_severity)
    elif joint.kind == "revolute" and max(abs(lower), abs(upper)) > MOST_DEG:
        headline = "the joint turns further than any hinge"
        yield finding(CODE, headline, where=where, value=value, bound=MOST_DEG, unit="deg", severity=Severity.WARNING)
    elif joint.kind == "revolute" and span <= RADIANS_MOST and max(abs(lower), abs(upper)) >= RADIANS_LEAST:
        headline = "the joint turns by a few degrees: are the limits in radians?"
        yield finding(
            CODE, headline, where=where, value=value, bound=RADIANS_MOST, unit="deg", severity=Severity.WARNING
        )
    elif joint.kind == "prismatic" and (travel_m := _travel(joint)) > (bound := SLIDE_ASSET_SIZES * asset_m) > 0.0:
        headline = "the joint slides further than the object is large"
        severity = subject.suspect_severity
        yield finding(CODE, headline, where=where, value=travel_m, bound=bound, unit="m", severity=severity)


def _travel(joint: Joint) -> float:
    """How far the joint slides from rest, the further way."""
    rest = joint.rest()
    at_rest = 0.0 if rest is None else rest.coordinate
    return max(abs(limit - at_rest) for limit in joint.limits)


RULE = Rule(
    CODE,
    "not locked; within 1080 deg and over 6.3 deg; slides <= 1.5 sizes of the object either way",
    "USD angles are degrees; ranges of real mechanisms",
    check,
)
