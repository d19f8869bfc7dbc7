"""Rule: a joint connects two different prims, at least one of them a rigid body."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Joint, Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-joint-bodies",
    "A joint does not join two different bodies",
    "Engines ignore it, weld something to the world, or refuse the file.",
    "name one existing body in body0 and another one in body1",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per joint whose ends are missing, lead nowhere, are several, the same, or both fixed."""
    for joint in subject.joints:
        faults = list(_faults(joint))
        for headline, value in faults:
            yield finding(CODE, headline, where=at(joint.prim), value=value)
        if not faults and subject.released:
            yield from _conventions(joint)


def _faults(joint: Joint) -> Iterator[tuple[str, str | None]]:
    for index, side in enumerate(joint.sides):
        if len(side.targets) > 1:
            yield f"body{index} names several prims", ", ".join(side.targets)
        elif side.targets and side.prim is None:
            yield f"body{index} names a prim that does not exist", side.targets[0]
        elif side.body is not None and not side.body.enabled:
            yield f"body{index} is disabled", side.body.path
    first, second = joint.sides
    if not first.targets and not second.targets:
        yield "the joint names no body", None
    elif first.targets and first.targets == second.targets:
        yield "the joint joins a body to itself", first.targets[0]
    elif not joint.bodies and all(side.prim is not None or not side.targets for side in joint.sides):
        yield "the joint joins nothing that moves", ", ".join(t for s in joint.sides for t in s.targets)
    elif len(joint.bodies) == 2 and joint.bodies[0].path == joint.bodies[1].path:
        yield "both ends belong to one body", joint.bodies[0].path


def _conventions(joint: Joint) -> Iterator[Diagnostic]:
    """Simulators disagree about joints that name part of a body, and about moving joints with one end missing."""
    for index, side in enumerate(joint.sides):
        if side.body is not None and side.prim != side.body.prim:
            headline = f"body{index} names a prim below the body {side.body.path}"
            yield finding(CODE, headline, where=at(joint.prim), value=str(side.prim.GetPath()))
        if not side.targets and joint.kind != "fixed":
            headline = f"body{index} is missing: the joint holds its body to the world"
            yield finding(CODE, headline, where=at(joint.prim))


RULE = Rule(CODE, "body0 and body1 name one existing prim each, of two bodies", "UsdPhysicsJoint; SimReady JT", check)
