"""Clearance and penetration between pairs of objects of which neither owns the other, in metres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, cast

import numpy as np
import shapely

from geom.polygon_measures import bounds
from scene_check.measures import overlap, polygons, separation
from scene_check.model import TOLERANCE_M, CheckObject, CheckScene, Violation, owners_of, same_place
from schemas.arrays import BoolArray, ObjectArray


def too_close(scene: CheckScene, by_name: dict[str, CheckObject], changed: frozenset[str]) -> Iterator[Violation]:
    """Clearance and penetration between objects that are not each other's owners, one of them among `changed`."""
    moved = np.array([item.name in changed for item in scene.objects], dtype=bool)
    near = _near(scene, moved)
    parts = [(k, prism) for k in np.flatnonzero(near).tolist() for prism in scene.objects[k].prisms]
    if not parts:
        return
    owner = np.array([k for k, _ in parts])
    low, high = np.array([p.low_m for _, p in parts]), np.array([p.high_m for _, p in parts])
    footprints = polygons([p.outline_m for _, p in parts])
    moved = moved[owner]
    changed_parts = np.flatnonzero(moved)
    margin = scene.clearance_m + TOLERANCE_M
    boxes = bounds(footprints[changed_parts]) + np.array([-margin, -margin, margin, margin])
    areas = cast(ObjectArray, shapely.box(*boxes.T))
    part_a, part_b = shapely.STRtree(footprints).query(areas)
    part_a = changed_parts[part_a]
    # Two changed objects find each other: the pair counts once, the earlier object first.
    keep = (owner[part_a] < owner[part_b]) | ((owner[part_a] > owner[part_b]) & ~moved[part_b])
    part_a, part_b = part_a[keep], part_b[keep]
    keep = shapely.dwithin(footprints[part_a], footprints[part_b], scene.clearance_m)
    part_a, part_b = part_a[keep], part_b[keep]
    part_a, part_b = np.where(owner[part_a] < owner[part_b], (part_a, part_b), (part_b, part_a))
    meet = np.minimum(high[part_a], high[part_b]) - np.maximum(low[part_a], low[part_b]) > TOLERANCE_M
    worst: dict[tuple[int, int], tuple[float, float]] = {}
    rows: Iterable[tuple[int, int, bool]] = zip(part_a.tolist(), part_b.tolist(), meet.tolist(), strict=True)
    for i, j, meets in rows:
        a, b = int(owner[i]), int(owner[j])
        scope = _judged(scene.objects[a], scene.objects[b], by_name)
        if scope == "owner" or (scope == "apart" and not meets):
            continue
        distance = float(footprints[i].distance(footprints[j]))
        value = distance if distance > 0.0 else separation(parts[i][1].outline_m, parts[j][1].outline_m)
        least, deepest = worst.get((a, b), (np.inf, 0.0))
        worst[a, b] = (min(least, value), max(deepest, -value if meets else 0.0))
    names = [item.name for item in scene.objects]
    for (a, b), (value, depth) in sorted(worst.items()):
        if depth > TOLERANCE_M:
            yield Violation("penetration", (names[a], names[b]), depth, 0.0)
        elif value < scene.clearance_m - TOLERANCE_M:
            yield Violation("clearance", (names[a], names[b]), value, scene.clearance_m)


def _near(scene: CheckScene, moved: BoolArray) -> BoolArray:
    """(n,) True for objects that changed, or whose bounding box is within the clearance of one that did."""
    box = np.array([item.box_m for item in scene.objects]).reshape(-1, 4)
    margin, changed_boxes = scene.clearance_m + 2.0 * TOLERANCE_M, box[moved]
    meet = (box[:, None, :2] <= changed_boxes[None, :, 2:] + margin) & (
        changed_boxes[None, :, :2] <= box[:, None, 2:] + margin
    )
    return moved | np.any(np.all(meet, axis=2), axis=1)


def _judged(
    object_a: CheckObject, object_b: CheckObject, by_name: dict[str, CheckObject]
) -> Literal["owner", "whole", "apart"]:
    """How a pair is judged: `owner` (not here), `whole` (of one place, heights overlap) or `apart` (prism by prism)."""
    if object_b.name in owners_of(object_a, by_name) or object_a.name in owners_of(object_b, by_name):
        return "owner"
    same = same_place(object_a.place, object_b.place) and overlap(
        (object_a.low_m, object_a.high_m), (object_b.low_m, object_b.high_m)
    )
    return "whole" if same else "apart"
