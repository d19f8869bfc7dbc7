"""Rule: mesh colliders of moving bodies are convex."""

from __future__ import annotations

from collections.abc import Iterator

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at, flag
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-collider-not-convex",
    "A moving mesh collider is not convex",
    "Engines refuse concave moving meshes or let them fall through the floor.",
    "decompose the mesh and set physics:approximation to convexHull",
)
CONVEX = ("convexHull", "convexDecomposition", "boundingCube", "boundingSphere")


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per mesh collider of a moving body whose approximation is none of the convex ones.

    Simulators either refuse moving triangle meshes or let them fall through the floor.
    """
    for body in subject.active_bodies:
        if flag(body.prim, "physics:kinematicEnabled", fallback=False) and not subject.released:
            continue
        for collider in body.active_colliders:
            if collider.approximation and collider.approximation not in CONVEX:
                yield finding(
                    CODE,
                    "a moving mesh collider is not convex",
                    where=at(collider.prim),
                    value=collider.approximation,
                    bound="convexHull",
                    severity=subject.suspect_severity,
                )


RULE = Rule(
    CODE, "approximation convexHull, convexDecomposition or a bounding shape", "UsdPhysicsMeshCollisionAPI", check
)
