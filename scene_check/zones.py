"""Violations of keep-outs and of the reach, from the placed objects (metres)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon

from scene_check.measures import largest, overlap, to_place
from scene_check.model import TOLERANCE_M, CheckObject, CheckScene, PosedPlace, Violation, owners_of
from schemas.scene.geometry import KeepOutVolume, ReachRing


def entered_keep_out(
    place: PosedPlace, rule: KeepOutVolume, scene: CheckScene, by_name: dict[str, CheckObject]
) -> Iterator[Violation]:
    """Objects that enter a keep-out of a place, each with the depth of its deepest part."""
    floor = float(place.origin_m[2])
    owner = by_name.get(place.owner)
    exempt: set[str] = {place.owner}
    if owner is not None:
        exempt |= owners_of(owner, by_name)
    inner = rule.polygon.buffer(-TOLERANCE_M, join_style="mitre")
    for item in scene.objects:
        if item.name in exempt:
            continue
        entered = [
            part
            for prism in item.prisms
            if overlap((prism.low_m - floor, prism.high_m - floor), (0.0, rule.height_m))
            and (part := Polygon(to_place(prism.outline_m, place)).intersection(inner)).area > TOLERANCE_M**2
        ]
        if entered:
            depth = max(shapely.maximum_inscribed_circle(largest(part)).length for part in entered)
            yield Violation("keep_out", (item.name,), float(depth), 0.0)


def out_of_reach(reach: ReachRing, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Objects whose origin lies outside the ring, nearer or farther."""
    for name in reach.members:
        distance = float(np.hypot(*(by_name[name].origin_m[:2] - reach.base_m[:2])))
        if distance > reach.most_m + TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.most_m)
        elif distance < reach.least_m - TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.least_m)
