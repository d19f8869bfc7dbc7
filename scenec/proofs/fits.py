"""Single things: too high for their place, no yaw at which they fit, or no usable fixed pose.

Theorem: if for every orientation and every yaw interval the region of the origin is empty, computed with the least
support of the outline along each wall and with its kernel over the interval as obstacle, then there is no pose.
"""

from __future__ import annotations

import numpy as np
import shapely
from shapely import Polygon

from geom.planar import turned
from scenec.ir.problem import Problem, Proof, Thing
from scenec.proofs.outlines import OUTLINE_SLACK_M, SMALLEST_CELL_RAD, YawCell, hull
from scenec.proofs.places import PlacementBounds, area, fits_height, free_region, placement_bounds
from scenec.proofs.swept_spaces import beside, certain_spaces
from schemas.scene.geometry import FixedPose, Stance
from source.tree import Path


def no_place_of_its_own(problem: Problem) -> Proof | None:
    """A proof for the first thing that has no pose even without all others."""
    for thing in problem.things:
        proof = _too_high(thing) or (
            _no_fixed_pose(problem, thing) if thing.domain.fixed_poses else _no_region(problem, thing)
        )
        if proof is not None:
            return proof
    return None


def _too_high(thing: Thing) -> Proof | None:
    resting_orientations = [thing.body.resting_orientations[k] for k in thing.domain.orientation_indices]
    if any(fits_height(thing, stance) for stance in resting_orientations) or thing.domain.fixed_poses:
        return None
    least, most = min(stance.height_m for stance in resting_orientations), thing.place.height_m
    text = f"{thing.name} is {least:.4g} m high at least; {thing.place.name} of {thing.parent} has {most:.4g} m"
    return Proof("empty-region", text, least, most, "m", (thing.path,))


def _no_region(problem: Problem, thing: Thing) -> Proof | None:
    tried = [
        thing.body.resting_orientations[k]
        for k in thing.domain.orientation_indices
        if fits_height(thing, thing.body.resting_orientations[k])
    ]
    for stance in tried:
        if _plainly(problem, thing, stance) or any_heading(
            placement_bounds(problem, thing, stance), thing.domain.yaw_rad
        ):
            return None
    narrow = min(float(np.ptp(hull(stance.prisms), axis=0).min()) for stance in tried)
    size = shapely.get_coordinates(shapely.minimum_rotated_rectangle(area(thing.place)))
    wide = float(np.hypot(*(size[1:3] - size[:2]).T).min())
    rules = tuple(r.path for r in problem.keep_outs if (r.parent, r.place.name) == (thing.parent, thing.place.name))
    spaces = certain_spaces(problem, thing)
    text = f"{thing.name} fits nowhere on {thing.place.name} of {thing.parent} within its ranges, at any heading"
    text += beside(spaces)
    swept = dict.fromkeys(space.path for space in spaces)
    owners = [other for other in problem.things if any(space.owner == other.name for space in problem.keep_clear)]
    owner_paths = (path for other in owners for path in (other.path, *_range_paths(other)) if spaces)
    paths = (thing.path, *_range_paths(thing), *rules, *swept, *owner_paths, *_reach_path(problem, thing))
    return Proof("empty-region", text, narrow, wide, "m", paths)


def _plainly(problem: Problem, thing: Thing, stance: Stance) -> bool:
    """Whether it fits in the middle of its ranges or place: a fast sufficient test for the usual case."""
    place, reach = thing.place, problem.reach
    bounded = any((rule.parent, rule.place.name) == (thing.parent, place.name) for rule in problem.keep_outs)
    bounded = bounded or bool(certain_spaces(problem, thing))
    if bounded or place.is_volume or place.above or (reach and thing.name in reach.members):
        return False
    ranges, middle = np.array([thing.domain.x_m, thing.domain.y_m]), shapely.get_coordinates(place.polygon.centroid)[0]
    at = np.clip(middle, ranges[:, 0], ranges[:, 1])
    outline = turned(hull(stance.prisms), (thing.domain.yaw_rad[0] + thing.domain.yaw_rad[1]) / 2.0)
    return place.polygon.covers(Polygon(outline + at))


def any_heading(place: PlacementBounds, yaw: YawCell) -> bool:
    """False only when no yaw of the interval leaves a region for the origin (halved down to a quarter of a degree)."""
    cells = [yaw]
    while cells:
        low, high = cells.pop()
        if shapely.is_empty(free_region(place, (low, high))):
            continue
        middle = (low + high) / 2.0
        if high - low < SMALLEST_CELL_RAD or not shapely.is_empty(free_region(place, (middle, middle))):
            return True
        cells += [(low, middle), (middle, high)]
    return False


def _range_paths(thing: Thing) -> tuple[Path, ...]:
    bounds = (("x", thing.domain.x_m), ("y", thing.domain.y_m), ("yaw", thing.domain.yaw_rad))
    free = {"x": np.inf, "y": np.inf, "yaw": 2.0 * np.pi - 1e-9}
    return tuple((*thing.domain.path, axis) for axis, (low, high) in bounds if high - low < free[axis])


def _reach_path(problem: Problem, thing: Thing) -> tuple[Path, ...]:
    return (problem.reach.path,) if problem.reach is not None and thing.name in problem.reach.members else ()


def _no_fixed_pose(problem: Problem, thing: Thing) -> Proof | None:
    if any(fixed_pose_usable(problem, thing, fixed_pose) for fixed_pose in thing.domain.fixed_poses):
        return None
    spaces = certain_spaces(problem, thing)
    text = f"none of the {len(thing.domain.fixed_poses)} written poses of {thing.name} is free of its place's bounds"
    text += beside(spaces)
    paths = (thing.path, thing.domain.path, *dict.fromkeys(space.path for space in spaces))
    return Proof("empty-domain", text, 0.0, 1.0, "poses", paths)


def fixed_pose_usable(problem: Problem, thing: Thing, fixed_pose: FixedPose) -> bool:
    """Whether one fixed pose is valid without all other things. True when in doubt."""
    stance = thing.body.resting_orientations[fixed_pose.stance]
    base = fixed_pose.z_m - stance.origin_height_m
    if base + stance.height_m > thing.place.height_m + OUTLINE_SLACK_M:
        return False
    origin = np.array([fixed_pose.x_m, fixed_pose.y_m])
    outlines = [Polygon(turned(prism.outline_m, fixed_pose.yaw_rad) + origin) for prism in stance.prisms]
    if not thing.place.is_volume and abs(base) <= OUTLINE_SLACK_M:
        allowed = thing.place.polygon.buffer(OUTLINE_SLACK_M, join_style="mitre")
        if not all(allowed.covers(outline) for outline in outlines):
            return False
    for rule in problem.keep_outs:
        if (rule.parent, rule.place.name) == (thing.parent, thing.place.name):
            inner = rule.polygon.buffer(-OUTLINE_SLACK_M, join_style="mitre")
            for prism, outline in zip(stance.prisms, outlines, strict=True):
                entered = min(base + prism.high_m, rule.height_m) - max(base + prism.low_m, 0.0) > OUTLINE_SLACK_M
                if entered and outline.intersection(inner).area > OUTLINE_SLACK_M:
                    return False
    for space in certain_spaces(problem, thing):
        inner = space.area.buffer(-OUTLINE_SLACK_M, join_style="mitre")
        for prism, outline in zip(stance.prisms, outlines, strict=True):
            entered = min(base + prism.high_m, space.high_m) - max(base + prism.low_m, space.low_m) > OUTLINE_SLACK_M
            if entered and outline.intersection(inner).area > OUTLINE_SLACK_M:
                return False
    ring = placement_bounds(problem, thing, stance).ring
    if ring is not None:
        centre, least, most = ring
        return least - OUTLINE_SLACK_M <= float(np.hypot(*(origin - centre))) <= most + OUTLINE_SLACK_M
    return True
