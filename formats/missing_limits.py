"""Limits for joints whose source states none, from where their links meet; a repair each, marked as inferred."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geom.collision_free_range import Surface, collision_free_range
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.model import Mesh
from schemas.outcome import INTAKE, Repair

CODE = "robot/missing-limit"
FREE_HINGE = "free_hinge"  # the repair of a hinge without limits, which turns without end
LEAST_SHARE = 0.01  # of the size, or of a turn: links that touch at rest leave no range to speak of
ONE_TURN = 2.0 * np.pi


def with_missing_limits(
    mechanism: Mechanism, meshes: Sequence[Mesh], repairs: Sequence[Repair] = ()
) -> tuple[Mechanism, tuple[Repair, ...]]:
    """The mechanism with limits on slides that have none, and on hinges that `repairs` name as `free_hinge`.

    A slide may move until its links meet others, at most by the size of the object either way. A hinge is limited where
    it meets something both ways within a turn; else it turns without end. `meshes` are those of all links at rest.
    Returns also `repairs`, with one for each joint that got limits.
    """
    surfaces = _surfaces(meshes)
    points = np.concatenate([mesh.points for mesh in meshes])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    free = {str(r.before.get("joint")) for r in repairs if r.name == FREE_HINGE}
    joints: list[MechanismJoint] = []
    answers: dict[str, Repair] = {}
    for joint in mechanism.joints:
        slides = joint.kind == "prismatic" and joint.limits is None
        turns = joint.kind == "continuous" and joint.source_name in free
        furthest = size if slides else ONE_TURN
        limits = low = high = None
        if slides or turns:
            low, high = collision_free_range(mechanism, joint, surfaces, furthest)
            limits = _limits(joint, low, high, furthest, slides=slides)
        if limits is not None:
            name = "limit_by_size" if (low, high) == (None, None) else "limit_by_collision"
            answers[joint.source_name] = _repair(name, joint, limits)
            joint = replace(joint, kind="prismatic" if slides else "revolute", limits=limits, limits_inferred=True)
        joints.append(joint)
    remaining = [r for r in repairs if r.name != FREE_HINGE or str(r.before.get("joint")) not in answers]
    return replace(mechanism, joints=tuple(joints)), (*remaining, *answers.values())


def _limits(
    joint: MechanismJoint, low: float | None, high: float | None, furthest: float, *, slides: bool
) -> tuple[float, float] | None:
    """The limits of a slide in any case; of a hinge None where it does not meet something both ways."""
    if not slides and (low is None or high is None):
        return None
    limits = joint.rest - furthest if low is None else low, joint.rest + furthest if high is None else high
    if limits[1] - limits[0] >= LEAST_SHARE * furthest:
        return limits
    return (joint.rest - furthest, joint.rest + furthest) if slides else None


def _surfaces(meshes: Sequence[Mesh]) -> dict[str, Surface]:
    by_link: dict[str, list[Mesh]] = {}
    for mesh in meshes:
        by_link.setdefault(mesh.link, []).append(mesh)
    joined: dict[str, Surface] = {}
    for link, members in by_link.items():
        starts = np.cumsum([0, *(len(mesh.points) for mesh in members)])
        triangles = [mesh.triangles + np.int32(first) for mesh, first in zip(members, starts, strict=False)]
        joined[link] = np.concatenate([mesh.points for mesh in members]), np.concatenate(triangles)
    return joined


def _repair(name: str, joint: MechanismJoint, limits: tuple[float, float]) -> Repair:
    return Repair(
        name=name,
        code=CODE,
        stage=INTAKE,
        before={"joint": joint.source_name, "limits": "none"},
        after={"joint": joint.source_name, "limits": f"{limits[0]:.6g} .. {limits[1]:.6g}"},
    )
