"""Violations of keep-outs, of spaces that joints sweep, and of the reach, from the placed objects (metres)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon

from scene_check.measures import largest, overlap, to_place
from scene_check.model import TOLERANCE_M, CheckObject, CheckScene, PosedPlace, SweptSpace, Violation, owners_of
from schemas.scene.geometry import KeepClear, KeepOutVolume, ReachRing


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


def entered_swept_space(swept: SweptSpace, scene: CheckScene, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Objects that are in the space that a joint sweeps, each with the depth of its deepest part."""
    space = swept.space
    exempt: set[str] = {space.owner}
    if space.owner in by_name:
        exempt |= owners_of(by_name[space.owner], by_name)
    cos, sin = np.cos(swept.yaw_rad), np.sin(swept.yaw_rad)
    turn_WP = np.array([[cos, -sin], [sin, cos]])
    for item in scene.objects:
        if item.name in exempt or _rides(item, space, by_name):
            continue
        depth = 0.0
        for layer in space.layers:
            inner = layer.polygon.buffer(-TOLERANCE_M, join_style="mitre")
            span = float(swept.origin_m[2]) + layer.low_m, float(swept.origin_m[2]) + layer.high_m
            for prism in item.prisms:
                if overlap((prism.low_m, prism.high_m), span):
                    outline = Polygon((prism.outline_m - swept.origin_m[:2]) @ turn_WP)
                    part = outline.intersection(inner)
                    if part.area > TOLERANCE_M**2:
                        depth = max(depth, float(shapely.maximum_inscribed_circle(largest(part)).length))
        if depth > 0.0:
            yield Violation("keep_clear", (item.name, space.owner), depth, 0.0, "m", space.joint)


def _rides(item: CheckObject, space: KeepClear, by_name: dict[str, CheckObject]) -> bool:
    """Whether an object, or what carries it, is on a place of the owner that moves with the joint."""
    seen: set[str] = set()
    while item.name not in seen:
        if item.place.owner == space.owner:
            return item.place.geometry.link in space.links
        if item.place.owner not in by_name:
            return False
        seen.add(item.name)
        item = by_name[item.place.owner]
    return False


def out_of_reach(reach: ReachRing, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Objects whose origin lies outside the ring, nearer or farther."""
    for name in reach.members:
        distance = float(np.hypot(*(by_name[name].origin_m[:2] - reach.base_m[:2])))
        if distance > reach.most_m + TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.most_m)
        elif distance < reach.least_m - TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.least_m)
