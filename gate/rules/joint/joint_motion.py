"""Rule: near the rest pose, joint motion does not push one link through the other."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Joint, Subject
from gate.subject.joint import ONE_DOF_KINDS
from gate.subject.overlap import deepest_penetration, hulls_along_motion, hulls_of
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-joint-motion",
    "A joint drives one link through the other",
    "The axis, the place of the joint or a limit is wrong: the drawer leaves through the side of its cabinet.",
    "check physics:axis, localPos, localRot and the limits; look at the asset at both limits",
)
MOTION_LEAST_M, MOTION_LEAST_SHARE = 0.01, 0.05  # of the smaller diagonal
MOTION_THROUGH = 0.9  # of the thinner hull
_MOTION_SHARES = (0.1, 0.25)  # of the way to each limit; near its limits many a robot can touch itself


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per joint that pushes one link through the other, from a rest pose in which they are apart.

    The axis, the place of the joint or a limit is then wrong: a drawer that leaves through the side of its cabinet.
    """
    for joint in subject.joints:
        if joint.enabled and joint.kind in ONE_DOF_KINDS and len(joint.bodies) == 2:
            yield from _penetration(joint)


def _penetration(joint: Joint) -> Iterator[Diagnostic]:
    first, second = joint.bodies
    hulls_a, hulls_b = hulls_of(first), hulls_of(second)
    bound_m = max(MOTION_LEAST_M, MOTION_LEAST_SHARE * min(first.diagonal_m, second.diagonal_m))
    if deepest_penetration(hulls_a, hulls_b)[0] > 0.1 * bound_m:
        return  # The links-overlap rule looks at these.
    for coordinate, moved in hulls_along_motion(joint, second, hulls_b, _MOTION_SHARES):
        depth_m, thickness_m = deepest_penetration(hulls_a, moved)
        if depth_m > min(bound_m, MOTION_THROUGH * thickness_m) and depth_m > MOTION_LEAST_M:
            yield finding(
                CODE,
                f"the joint drives {second.path} through {first.path} at {coordinate:.3g} {joint.unit}",
                where=at(joint.prim),
                value=depth_m,
                bound=bound_m,
                unit="m",
                severity=Severity.WARNING,
            )
            return


RULE = Rule(
    CODE,
    "no overlap over 1 cm and 5 % of the smaller link (or 90 % of the thinner hull) in the first quarter of the way",
    "exact penetration depth at a tenth and a quarter of the way to each limit",
    check,
)
