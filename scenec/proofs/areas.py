"""Area bound: the footprints on a place need more area than it has.

Theorem: footprints at least c apart, each grown by c/2, have disjoint interiors, and all lie in their place grown by
c/2; so the sum of their grown areas is at most the grown area of the place.

Grown by r, a region of area A and boundary length L has at most A + r L + pi r^2 (Steiner; equality for convex ones).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon

from scenec.ir.problem import Problem, Proof, Thing
from scenec.proofs.outlines import hull, support_bounds
from scenec.proofs.places import area

Rectangle = tuple[float, float, float, float]


def more_area_than_there_is(problem: Problem) -> Proof | None:
    """A proof for the first place, or part of a place that ranges share, with less area than its footprints need."""
    places: dict[tuple[str, str], list[Thing]] = {}
    for thing in problem.things:
        places.setdefault((thing.parent, thing.place.name), []).append(thing)
    for things in places.values():
        for stretch, within in _stretches(_side_by_side(things)):
            proof = _over_full(problem, within, stretch)
            if proof is not None:
                return proof
    return None


def _side_by_side(things: list[Thing]) -> list[Thing]:
    """Things of which no two can overlap in the plane: all on a surface; in a volume those too high to stack."""
    place = things[0].place
    if not place.is_volume:
        return things
    height = {
        thing.name: min(thing.body.resting_orientations[k].height_m for k in thing.domain.orientation_indices)
        for thing in things
    }
    side_by_side: list[Thing] = []
    for thing in sorted(things, key=lambda thing: -height[thing.name]):
        if side_by_side and height[side_by_side[-1].name] + height[thing.name] <= place.height_m + 1e-5:
            break
        side_by_side.append(thing)
    return side_by_side


def _stretches(things: list[Thing]) -> Iterator[tuple[Polygon | None, list[Thing]]]:
    """Rectangles common to ranges, each with the things that must lie inside; then the whole place."""
    boxes = {thing.name: _covered(thing) for thing in things}
    for low_x, low_y, high_x, high_y in dict.fromkeys(box for box in boxes.values() if np.isfinite(box).all()):
        inside = [
            thing
            for thing in things
            for box in [boxes[thing.name]]
            if box[0] >= low_x and box[1] >= low_y and box[2] <= high_x and box[3] <= high_y
        ]
        if len(inside) > 1:
            yield shapely.box(low_x, low_y, high_x, high_y), inside
    yield None, things


def _covered(thing: Thing) -> Rectangle:
    """The rectangle in A that contains the footprint by its ranges."""
    extents = [
        [
            support_bounds(hull(thing.body.resting_orientations[k].prisms), axis, thing.domain.yaw_rad)[1]
            for k in thing.domain.orientation_indices
        ]
        for axis in np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    ]
    west, south, east, north = (max(values) for values in extents)
    if thing.domain.fixed_poses:
        return (-np.inf, -np.inf, np.inf, np.inf)
    (x0, x1), (y0, y1) = thing.domain.x_m, thing.domain.y_m
    return x0 - west, y0 - south, x1 + east, y1 + north


def _over_full(problem: Problem, things: list[Thing], stretch: Polygon | None) -> Proof | None:
    things = [thing for thing in things if not thing.domain.fixed_poses]
    half = problem.clearance_m / 2.0
    needed = sum(min(_grown_area(thing, k, half) for k in thing.domain.orientation_indices) for thing in things)
    if not things:
        return None
    place = things[0].place
    container = area(place) if stretch is None else shapely.intersection(area(place), stretch)
    room = float(shapely.area(container) + half * shapely.length(container) + np.pi * half * half)
    if needed <= room * (1.0 + 1e-6) + 1e-9:
        return None
    where = place.name if stretch is None else f"the stretch of {place.name} that their ranges leave them"
    text = f"{len(things)} things need {needed:.4g} m2 with their clearance; {where} has {room:.4g} m2"
    paths = tuple(dict.fromkeys(thing.path for thing in things))
    ranges = () if stretch is None else tuple(dict.fromkeys(thing.domain.path for thing in things))
    return Proof("area-bound", text, needed, room, "m2", (*paths, *ranges))


def _grown_area(thing: Thing, stance: int, half_m: float) -> float:
    """Area of the whole footprint grown by half the clearance, from below (arcs are replaced by chords)."""
    footprint = shapely.union_all(
        [Polygon(prism.outline_m) for prism in thing.body.resting_orientations[stance].prisms]
    )
    return float(footprint.buffer(half_m, quad_segs=8).area)
