"""Static stability of piles inside a volume, for any masses of the contents (metres, in W).

Contact is where a foot lies over a top, at heights within CONTACT_M: pieces of one level face differ a little. The
support of an object is the hull of its contacts; of one on the floor, the hull of its foot. A body at rest balances
when its weight and the loads on it pass through its support. An object on one other passes its load down through the
hull of its own centroid and of the loads on it; an object on several may load them anywhere in contact. So all of these
points must lie in the support of each object. INSIDE is the margin of the centroid: a ball, which touches in a point,
supports nothing and rests on no contents.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from geom.polygon_measures import distances
from scene_check.model import TOLERANCE_M, CheckObject, CheckScene, Violation

CONTACT_M = 2e-4
INSIDE = 0.2  # share of the radius of a disc as large as the footprint


def is_lifted(item: CheckObject) -> bool:
    """Whether other contents of its volume must support an object."""
    return bool(item.place.geometry.layers) and not item.domain.fixed_poses and _lift(item) > TOLERANCE_M


def unstable_stacks(scene: CheckScene) -> Iterator[Violation]:
    """Violations by objects of piles that are not supported, or that the objects on them would tip: how far a centroid
    or a load lies outside of the support."""
    inside: dict[tuple[str, str], list[CheckObject]] = defaultdict(list)
    for item in scene.objects:
        if item.place.geometry.layers:
            inside[item.place.owner, item.place.geometry.name].append(item)
    for contents in inside.values():
        if any(is_lifted(item) for item in contents):
            yield from _tipped(contents)


def _tipped(contents: list[CheckObject]) -> Iterator[Violation]:
    # From the top down, so that all loads on an object are known when its turn comes.
    loads_on: dict[str, list[BaseGeometry]] = defaultdict(list)
    for item in sorted(contents, key=lambda item: -item.low_m):
        footprint = shapely.union_all([Polygon(prism.outline_m) for prism in item.prisms])
        middle, loads = footprint.centroid, loads_on[item.name]
        touched = {o.name: area for o in contents if o is not item and not (area := contact(item, o)).is_empty}
        if is_lifted(item):
            support = shapely.union_all(list(touched.values())).convex_hull
            if support.is_empty:
                yield Violation("unsupported", (item.name, item.place.owner), _lift(item), 0.0)
                continue
            room_m = INSIDE * float(np.sqrt(footprint.area / np.pi))
            inside_m = float(middle.distance(support.boundary)) if support.covers(middle) else -middle.distance(support)
            beyond = [room_m - (inside_m if support.area > 0.0 else 0.0)]
        else:
            touched, support = {}, foot_of(item).convex_hull
            beyond = [float(middle.distance(support))] if loads else []
        beyond += [_farthest(load, support) for load in loads]
        if max(beyond, default=0.0) > TOLERANCE_M:
            yield Violation("unsupported", (item.name, item.place.owner), max(beyond), 0.0)
            continue  # its load on others is not known
        for name, area in touched.items():
            loads_on[name] += [area] if len(touched) > 1 else [middle, *loads]


def _lift(item: CheckObject) -> float:
    return float(item.low_m - item.place.origin_m[2])


def _farthest(load: BaseGeometry, support: BaseGeometry) -> float:
    """Largest distance of a point of a load outside of a support."""
    return float(distances(shapely.points(shapely.get_coordinates(load)), support).max())


def foot_of(item: CheckObject) -> BaseGeometry:
    """The area, in W, of the lowest pieces of an object."""
    return shapely.union_all([Polygon(p.outline_m) for p in item.prisms if p.low_m <= item.low_m + CONTACT_M])


def contact(item: CheckObject, other: CheckObject) -> BaseGeometry:
    """The area, in W, in which an object touches the top of another from above."""
    tops = [Polygon(p.outline_m) for p in other.prisms if -CONTACT_M <= p.high_m - item.low_m <= 2.0 * TOLERANCE_M]
    return shapely.union_all(tops).intersection(foot_of(item)) if tops else Polygon()
