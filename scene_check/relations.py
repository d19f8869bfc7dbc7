"""Violations of the relations, keep-outs and reach of a program, from the placed objects (metres, radians)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon

from scene_check.measures import largest, overlap, polygons, to_place
from scene_check.model import (
    TOLERANCE_M,
    CheckKeepOut,
    CheckObject,
    CheckReach,
    CheckRelation,
    CheckScene,
    Violation,
    owners_of,
)


def broken_relation(relation: CheckRelation, items: list[CheckObject]) -> Iterator[Violation]:
    """A violation with the measured value where the relation does not hold."""
    value, bound, ok, unit = _relation_value(relation, items)
    if not ok:
        yield Violation("relation", relation.objects, value, bound, unit, relation.label or relation.kind)


def _relation_value(relation: CheckRelation, items: list[CheckObject]) -> tuple[float, float, bool, str]:
    """(value, bound, whether it holds, unit) of one relation."""
    origins = np.array([item.origin_m[:2] for item in items])
    along, across = np.asarray(relation.direction), np.array([-relation.direction[1], relation.direction[0]])
    if relation.kind == "before":
        end = max(float((prism.outline_m @ along).max()) for prism in items[0].prisms)
        begin = min(float((prism.outline_m @ along).min()) for prism in items[1].prisms)
        return begin - end, relation.gap_m, begin - end >= relation.gap_m - TOLERANCE_M, "m"
    if relation.kind in ("near", "far_from"):
        area_a, area_b = (shapely.union_all(polygons([p.outline_m for p in item.prisms])) for item in items[:2])
        distance = float(area_a.distance(area_b))
        excess = distance - relation.gap_m if relation.kind == "near" else relation.gap_m - distance
        return distance, relation.gap_m, excess <= TOLERANCE_M, "m"
    if relation.kind == "aligned":
        offset = float(np.ptp(origins @ across))
        return offset, relation.tolerance, offset <= relation.tolerance + TOLERANCE_M, "m"
    if relation.kind == "facing":
        toward, front = origins[1] - origins[0], items[0].front
        angle = float(abs(np.arctan2(front[0] * toward[1] - front[1] * toward[0], front @ toward)))
        seen = min(np.hypot(*toward), np.hypot(*front)) > TOLERANCE_M
        return angle, relation.tolerance, bool(seen) and angle <= relation.tolerance + TOLERANCE_M, "rad"
    if relation.kind == "between":
        line = origins[2] - origins[1]
        length = float(np.hypot(*line))
        if length <= TOLERANCE_M:
            return 0.0, relation.tolerance, False, "m"
        step = origins[0] - origins[1]
        past, beside = float(step @ line) / length, abs(float(step[0] * line[1] - step[1] * line[0])) / length
        beyond = max(-past, past - length, 0.0)
        inside = beyond <= TOLERANCE_M and beside <= relation.tolerance + TOLERANCE_M
        return max(beyond, beside), relation.tolerance, inside, "m"
    raise ValueError(f"unknown relation kind {relation.kind}")


def entered_keep_out(rule: CheckKeepOut, scene: CheckScene, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Objects that enter a keep-out, each with the depth of its deepest part."""
    floor = float(rule.place.origin_m[2])
    owner = by_name.get(rule.place.owner)
    exempt = {rule.place.owner} if owner is None else {rule.place.owner} | owners_of(owner, by_name)
    inner = rule.polygon.buffer(-TOLERANCE_M, join_style="mitre")
    for item in scene.objects:
        if item.name in exempt:
            continue
        entered = [
            part
            for prism in item.prisms
            if overlap((prism.low_m - floor, prism.high_m - floor), (0.0, rule.height_m))
            and (part := Polygon(to_place(prism.outline_m, rule.place)).intersection(inner)).area > TOLERANCE_M**2
        ]
        if entered:
            depth = max(shapely.maximum_inscribed_circle(largest(part)).length for part in entered)
            yield Violation("keep_out", (item.name,), float(depth), 0.0, "m", rule.label)


def out_of_reach(reach: CheckReach, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Objects whose origin lies outside the ring, nearer or farther."""
    for name in reach.objects:
        distance = float(np.hypot(*(by_name[name].origin_m[:2] - reach.base_m[:2])))
        if distance > reach.most_m + TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.most_m)
        elif distance < reach.least_m - TOLERANCE_M:
            yield Violation("reach", (name,), distance, reach.least_m)
