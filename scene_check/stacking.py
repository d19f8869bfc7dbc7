"""Contents of a volume that stand on other contents: does the pile stay, whatever its parts weigh?

Contact is where a foot lies over a top, at heights within CONTACT_M: pieces of one level face differ a little. The
support of an object is the hull of its contacts; of one on the floor, the hull of its foot. A body at rest balances
when its weight and the forces on it pass through its support. What stands on one other passes down a force through
the hull of its own middle and of the forces on it; what stands on several may press anywhere it touches. So all of
these points must lie in the support of each object. By how much a middle must lie inside says INSIDE: a ball, which
touches in a point, holds nothing and stands on no contents.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from scene_check.model import TOLERANCE_M, CheckObject, CheckScene, Violation

CONTACT_M = 2e-4
INSIDE = 0.2  # share of the radius of a disc as large as the footprint


def in_the_air(item: CheckObject) -> bool:
    """Whether something else in its volume has to hold an object."""
    return bool(item.place.layers) and not item.spots and _lift(item) > TOLERANCE_M


def tipped(scene: CheckScene) -> Iterator[Violation]:
    """Objects of piles that are not held, or that what stands on them would tip: how far a middle or a pressure lies
    outside of the support."""
    inside: dict[tuple[str, str], list[CheckObject]] = defaultdict(list)
    for item in scene.objects:
        if item.place.layers:
            inside[item.place.owner, item.place.name].append(item)
    for contents in inside.values():
        if any(in_the_air(item) for item in contents):
            yield from _tipped(contents)


def _tipped(contents: list[CheckObject]) -> Iterator[Violation]:
    # From the top down, so that all that presses on an object is known when its turn comes.
    presses: dict[str, list[BaseGeometry]] = defaultdict(list)
    for item in sorted(contents, key=lambda item: -item.low_m):
        footprint = shapely.union_all([Polygon(prism.outline_m) for prism in item.prisms])
        middle, loads = footprint.centroid, presses[item.name]
        touched = {o.name: area for o in contents if o is not item and not (area := _contact(item, o)).is_empty}
        if in_the_air(item):
            support = shapely.union_all(list(touched.values())).convex_hull
            if support.is_empty:
                yield Violation("unsupported", (item.name, item.place.owner), _lift(item), 0.0)
                continue
            room_m = INSIDE * float(np.sqrt(footprint.area / np.pi))
            inside_m = float(middle.distance(support.boundary)) if support.covers(middle) else -middle.distance(support)
            beyond = [room_m - (inside_m if support.area > 0.0 else 0.0)]
        else:
            touched, support = {}, _foot(item).convex_hull
            beyond = [float(middle.distance(support))] if loads else []
        beyond += [_farthest(load, support) for load in loads]
        if max(beyond, default=0.0) > TOLERANCE_M:
            yield Violation("unsupported", (item.name, item.place.owner), max(beyond), 0.0)
            continue  # where it presses is not known
        for name, area in touched.items():
            presses[name] += [area] if len(touched) > 1 else [middle, *loads]


def _lift(item: CheckObject) -> float:
    return float(item.low_m - item.place.origin_m[2])


def _farthest(load: BaseGeometry, support: BaseGeometry) -> float:
    """How far any point of a load lies outside of a support."""
    return float(shapely.distance(shapely.points(shapely.get_coordinates(load)), support).max())


def _foot(item: CheckObject) -> BaseGeometry:
    return shapely.union_all([Polygon(p.outline_m) for p in item.prisms if p.low_m <= item.low_m + CONTACT_M])


def _contact(item: CheckObject, other: CheckObject) -> BaseGeometry:
    """Where an object touches the top of another from above, in W."""
    tops = [Polygon(p.outline_m) for p in other.prisms if -CONTACT_M <= p.high_m - item.low_m <= 2.0 * TOLERANCE_M]
    return shapely.union_all(tops).intersection(_foot(item)) if tops else Polygon()
