"""Obstacles on a place for failure pictures: parts of its owner, things with one pose, the best partial assignment."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from scenec.ir.problem import Exhausted, Placement, Problem, Result, Thing
from schemas.arrays import FloatArray


def owner_parts(problem: Problem, parent: str, anchor: str) -> list[BaseGeometry]:
    """Outlines in A of the parts of the owner above its surface: rims, posts, walls."""
    places = {id(t.place): t.place for t in problem.things if (t.parent, t.place.name) == (parent, anchor)}
    return [shapely.Polygon(prism.outline_m) for place in places.values() for prism in place.above]


def obstructing_things(problem: Problem, result: Result, parent: str, anchor: str) -> Iterator[tuple[Thing, Placement]]:
    """Things of a place with their pose in the best partial assignment, or with the only pose that they may have;
    without the one that failed most."""
    at_best = result.best_placements if isinstance(result, Exhausted) else {}
    failing = result.blocking if isinstance(result, Exhausted) else None
    for thing in problem.things:
        if (thing.parent, thing.place.name) == (parent, anchor) and thing.name != failing:
            at = at_best.get(thing.name) or only_pose(thing)
            if at is not None:
                yield thing, at


def only_pose(thing: Thing) -> Placement | None:
    """The pose of a thing that may have no other, None for one that may."""
    domain = thing.domain
    if len(domain.fixed_poses) == 1:
        fixed_pose = domain.fixed_poses[0]
        return Placement(fixed_pose.x_m, fixed_pose.y_m, fixed_pose.yaw_rad, fixed_pose.stance)
    spans = (domain.x_m, domain.y_m, domain.yaw_rad)
    if domain.fixed_poses or len(domain.orientation_indices) != 1 or any(low != high for low, high in spans):
        return None
    return Placement(domain.x_m[0], domain.y_m[0], domain.yaw_rad[0], domain.orientation_indices[0])


def footprint(thing: Thing, at: Placement) -> BaseGeometry:
    """The footprint in A of a thing at a pose."""
    return footprint_at(thing, at.stance, at.yaw_rad, np.array([at.x_m, at.y_m]))


def footprint_at(thing: Thing, stance: int, yaw_rad: float, at: FloatArray) -> BaseGeometry:
    """The footprint in A of a thing in a stance at a yaw, its origin at `at` (2,)."""
    cosine, sine = np.cos(yaw_rad), np.sin(yaw_rad)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    return shapely.union_all(
        [shapely.Polygon(prism.outline_m @ turn + at) for prism in thing.body.resting_orientations[stance].prisms]
    )
