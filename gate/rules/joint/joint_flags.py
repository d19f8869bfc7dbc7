"""Rule: joints are active and do not break."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-joint-flags",
    "A joint is disabled, breaks or has negative friction",
    "The mechanism falls apart or gains energy.",
    "enable the joint, leave break force and torque infinite, keep damping and friction positive",
)
BREAKS = ("physics:breakForce", "physics:breakTorque")
NOT_NEGATIVE = (
    "physxJoint:armature",
    "physxJoint:jointFriction",
    "physxJoint:maxJointVelocity",
    "newton:armature",
    "newton:friction",
    "newton:damping",
    "mjc:armature",
    "mjc:damping",
    "mjc:frictionloss",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per disabled joint, per joint that breaks at once or ever, per negative friction, damping, armature."""
    for joint in subject.joints:
        where = at(joint.prim)
        if not joint.enabled:
            yield finding(CODE, "the joint is disabled", where=where, severity=subject.suspect_severity)
        for name in BREAKS:
            value = number(joint.prim, name, np.inf)
            if not value > 0.0:
                yield finding(CODE, f"{name} is not positive: the joint breaks at once", where=where, value=value)
            elif np.isfinite(value) and subject.released:
                headline = f"{name} lets the joint break"
                yield finding(CODE, headline, where=where, value=value, bound=np.inf, severity=Severity.WARNING)
        for name in NOT_NEGATIVE:
            value = number(joint.prim, name, 0.0)
            if not value >= 0.0:
                yield finding(CODE, f"{name} is negative or no number", where=where, value=value, bound=0.0)


RULE = Rule(CODE, "enabled; break force and torque > 0; friction, damping, armature >= 0", "UsdPhysicsJoint", check)
