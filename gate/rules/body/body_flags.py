"""Rule: bodies are simulated, free to move and subject to gravity."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, flag, number
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-body-flags",
    "A body is disabled, kinematic, asleep, locked or weightless",
    "It hangs in the air or cannot be moved, and nothing on the screen says why.",
    "set rigidBodyEnabled true, kinematicEnabled and startsAsleep false, and leave gravity on",
)
# attribute, what it means when true, and how grave that is on a file that claims nothing
FLAGS = (
    ("physics:kinematicEnabled", "the body is kinematic: nothing it meets can move it", Severity.WARNING),
    ("physics:startsAsleep", "the body starts asleep: it hangs in the air until touched", Severity.WARNING),
    ("physxRigidBody:disableGravity", "gravity is off for the body", Severity.INFO),
    ("physxRigidBody:lockedPosAxis", "translations of the body are locked", Severity.INFO),
    ("physxRigidBody:lockedRotAxis", "rotations of the body are locked", Severity.INFO),
)
DAMPING = ("physxRigidBody:linearDamping", "physxRigidBody:angularDamping")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per flag that takes a body out of the simulation or of gravity, and per impossible damping."""
    joined = {body.path for joint in subject.joints for body in joint.bodies}
    for body in subject.bodies:
        where = at(body.prim)
        if not body.enabled:
            headline = "the body is disabled: it is scenery"
            yield finding(CODE, headline, where=where, severity=subject.suspect_severity)
        for name, headline, elsewhere in FLAGS:
            if flag(body.prim, name, fallback=False):
                severity = Severity.ERROR if subject.released else elsewhere
                if name == "physics:kinematicEnabled" and body.path in joined:
                    headline = "a jointed body is kinematic: its joints cannot move it"
                yield finding(CODE, headline, where=where, value=f"{name} = true", bound="false", severity=severity)
        for name in DAMPING:
            damping = number(body.prim, name, 0.0)
            if not (damping >= 0.0 and np.isfinite(damping)):
                headline = f"{name} is negative or not finite"
                yield finding(CODE, headline, where=where, value=damping, bound=0.0)


RULE = Rule(
    CODE,
    "enabled, not kinematic, awake, with gravity, unlocked; damping >= 0",
    "UsdPhysicsRigidBodyAPI, PhysX schema",
    check,
)
