"""Converts a problem and its placements to the input of the independent judge (`scene_check`), all in the world
frame."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from scene_check import CheckObject, CheckScene, Violation, check
from scene_check.batch import object_in_world, place_in_world, relation_in_world
from scene_check.model import PosedGrid, PosedPlace, SweptSpace
from scenec.emit.scene import world_frames
from scenec.ir.derivation_cache import DerivationCache
from scenec.ir.problem import Placement, Problem, Thing
from schemas.arrays import FloatArray
from schemas.scene.geometry import Domain

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
    standing_on = {thing.name: problem.standing_on(thing) for thing in problem.things}
    stood_on = {(owner, id(place)): place for owner, place in standing_on.values()}
    places = {
        key: derivations.get(
            ("place", problem.key, key), partial(place_in_world, key[0], place, *poses[key[0]]), place, frames[key[0]]
        )
        for key, place in stood_on.items()
    }

    def standing(thing: Thing) -> CheckObject:
        name, at, (owner, ground) = thing.name, placements[thing.name], standing_on[thing.name]
        place = places[owner, id(ground)]
        stance = thing.body.resting_orientations[at.stance]
        make = partial(object_in_world, name, at.stance, stance, _domain(problem, thing), place, *poses[name])
        return derivations.get(("object", problem.key, name), make, thing, at, frames[name], place)

    objects = tuple(standing(thing) for thing in problem.things if not thing.is_frame)
    keep_outs = tuple(
        (place_in_world(rule.parent, rule.place, *poses[rule.parent]), rule) for rule in problem.keep_outs
    )
    keep_clear = tuple(SweptSpace(space, *poses[space.owner]) for space in problem.keep_clear)
    relations = tuple(
        derivations.get(
            ("relation", problem.key, k),
            partial(relation_in_world, relation, poses[relation.frame][1]),
            relation,
            frames[relation.frame],
        )
        for k, relation in enumerate(problem.relations)
    )
    return CheckScene(
        objects,
        problem.clearance_m,
        relations,
        keep_outs,
        problem.reach,
        keep_clear,
        problem.stacks,
        tuple(_grids(problem, places)),
    )


def _domain(problem: Problem, thing: Thing) -> Domain:
    """Where a thing may be on its place. A member of a grid is bound by its grid alone."""
    return Domain() if thing.parent in problem.frames else thing.domain


def _grids(problem: Problem, places: Mapping[tuple[str, int], PosedPlace]) -> Iterator[PosedGrid]:
    for name, frame in problem.frames.items():
        members = [thing for thing in problem.things if thing.parent == name]
        offsets = np.array([[pose.x_m, pose.y_m] for thing in members for pose in thing.domain.fixed_poses])
        place = places[frame.parent, id(frame.place)]
        yield PosedGrid(name, tuple(thing.name for thing in members), offsets, place, frame.domain)


def world_poses(problem: Problem, placements: dict[str, Placement]) -> dict[str, LevelPose]:
    """Origin and yaw in W of the background and every thing, from the frames that are emitted.

    Raises KeyError when a thing has no placement.
    """
    return {name: _level(X_WU) for name, X_WU in world_frames(problem, placements).items()}


def _level(X_WU: FloatArray) -> LevelPose:
    return X_WU[:3, 3], math.atan2(X_WU[1, 0], X_WU[0, 0])
