"""Converts a problem and its placements to the input of the independent judge (`scene_check`), all in the world
frame."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from geom.planar import front_of, turned
from scene_check import (
    CheckKeepOut,
    CheckObject,
    CheckPlace,
    CheckPrism,
    CheckReach,
    CheckRelation,
    CheckScene,
    Violation,
    check,
)
from scenec.emit.scene import world_frames
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.problem import FixedPose, Placement, Problem, RelationIR, Slab, Surface, Thing, Volume
from schemas.arrays import FloatArray

LevelPose = tuple[FloatArray, float]  # origin (3,) in W and yaw: supports are level


def violations(
    problem: Problem, placements: dict[str, Placement], derivations: DerivationCache | None = None
) -> tuple[Violation, ...]:
    """Violations that the independent judge finds in a complete assignment; empty when the scene is valid.

    Where `derivations` holds the last valid scene of this combination, only what differs from it is judged again.
    """
    scene = check_scene(problem, placements, derivations)
    if derivations is None:
        return check(scene)
    last = derivations.get(("judged", problem.key), list[CheckScene])  # none, or the last valid scene
    scene_violations = check(scene, last[0] if last else None)
    last[:] = [] if scene_violations else [scene]
    return scene_violations


def check_scene(
    problem: Problem, placements: dict[str, Placement], derivations: DerivationCache | None = None
) -> CheckScene:
    """The scene in the world. Raises KeyError when a thing has no placement: a partial scene is no scene.

    Parts in `derivations` are the same Python objects as in the scene before.
    """
    derivations = derivations or DerivationCache()
    frames = world_frames(problem, placements, derivations)
    poses = {name: _level(X_WU) for name, X_WU in frames.items()}
    stood_on = {(thing.parent, id(thing.place)): thing.place for thing in problem.things}
    places = {
        key: derivations.get(("place", problem.key, key), partial(_place, key[0], place, poses), place, frames[key[0]])
        for key, place in stood_on.items()
    }

    def standing(thing: Thing) -> CheckObject:
        name, at, place = thing.name, placements[thing.name], places[thing.parent, id(thing.place)]
        make = partial(_object, thing, at, poses[name], place)
        return derivations.get(("object", problem.key, name), make, thing, at, frames[name], place)

    objects = tuple(standing(thing) for thing in problem.things)
    keep_outs = tuple(
        CheckKeepOut(_place(rule.parent, rule.place, poses), rule.polygon, rule.height_m) for rule in problem.keep_outs
    )
    reach = problem.reach
    relations = tuple(
        derivations.get(
            ("relation", problem.key, k), partial(_relation, relation, poses), relation, frames[relation.frame]
        )
        for k, relation in enumerate(problem.relations)
    )
    ring = None if reach is None else CheckReach(reach.base_m, reach.least_m, reach.most_m, reach.members)
    return CheckScene(objects, problem.clearance_m, relations, keep_outs, ring)


def world_poses(problem: Problem, placements: dict[str, Placement]) -> dict[str, LevelPose]:
    """Origin and yaw in W of the background and every thing, from the frames that are emitted.

    Raises KeyError when a thing has no placement.
    """
    return {name: _level(X_WU) for name, X_WU in world_frames(problem, placements).items()}


def _level(X_WU: FloatArray) -> LevelPose:
    return X_WU[:3, 3], math.atan2(X_WU[1, 0], X_WU[0, 0])


def _anchor(owner: str, place: Surface | Volume, poses: dict[str, LevelPose]) -> LevelPose:
    origin, yaw = poses[owner]
    shift = turned(place.origin_P_m[None, :2], yaw)[0]
    return origin + np.array([*shift, place.origin_P_m[2]]), yaw


def _place(owner: str, place: Surface | Volume, poses: dict[str, LevelPose]) -> CheckPlace:
    origin, yaw = _anchor(owner, place, poses)
    if isinstance(place, Volume):
        return CheckPlace(owner, place.name, origin, yaw, layers=place.layers, height_m=place.height_m)
    above = tuple(CheckPrism(slab.outline_m, slab.low_m, slab.high_m) for slab in place.above)
    return CheckPlace(owner, place.name, origin, yaw, place.polygon, height_m=place.clearance_m, above=above)


def _relation(relation: RelationIR, poses: dict[str, LevelPose]) -> CheckRelation:
    return CheckRelation(
        kind=relation.kind,
        objects=relation.things,
        direction=turned(np.array([relation.direction]), poses[relation.frame][1])[0],
        gap_m=relation.gap_m,
        tolerance=relation.tolerance,
        label=relation.word or relation.kind,
    )


def _object(thing: Thing, at: Placement, pose: LevelPose, place: CheckPlace) -> CheckObject:
    origin, yaw = pose
    stance, domain = thing.body.resting_orientations[at.stance], thing.domain
    floor = float(place.origin_m[2]) + at.base_m
    has_fixed_pose = any(fixed_pose.stance == at.stance for fixed_pose in domain.fixed_poses)
    return CheckObject(
        name=thing.name,
        prisms=tuple(_prism(slab, origin, yaw, floor) for slab in stance.slabs),
        origin_m=origin,
        yaw_rad=yaw,
        front=turned(front_of(stance.quat_wxyz)[None], yaw)[0],
        place=place,
        x_m=domain.x_m,
        y_m=domain.y_m,
        yaw_range_rad=domain.yaw_rad,
        fixed_poses=tuple(
            _fixed_pose(fixed_pose)
            for fixed_pose in domain.fixed_poses
            if fixed_pose.stance == at.stance or not has_fixed_pose
        ),
        stance=at.stance,
        stances=tuple(fixed_pose.stance for fixed_pose in domain.fixed_poses) or domain.orientation_indices,
    )


def _prism(slab: Slab, origin: FloatArray, yaw: float, floor_m: float) -> CheckPrism:
    return CheckPrism(turned(slab.outline_m, yaw) + origin[:2], floor_m + slab.low_m, floor_m + slab.high_m)


def _fixed_pose(fixed_pose: FixedPose) -> tuple[float, float, float, float]:
    return fixed_pose.x_m, fixed_pose.y_m, fixed_pose.z_m, fixed_pose.yaw_rad
