"""Two objects that are not each other's owners: clearance and penetration."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal

import numpy as np
import shapely

from geom.scene_check.measures import overlap, polygons, separation
from geom.scene_check.model import TOLERANCE_M, CheckObject, CheckScene, Violation, owners_of, same_place


def too_close(scene: CheckScene, by_name: dict[str, CheckObject]) -> Iterator[Violation]:
    """Clearance and penetration between objects that are not each other's owners."""
    parts = [(k, prism) for k, item in enumerate(scene.objects) for prism in item.prisms]
    if not parts:
        return
    owner = np.array([k for k, _ in parts])
    low, high = np.array([p.low_m for _, p in parts]), np.array([p.high_m for _, p in parts])
    seen = polygons([p.outline_m for _, p in parts])
    one, two = shapely.STRtree(seen).query(seen, predicate="dwithin", distance=scene.clearance_m)
    keep = owner[one] < owner[two]
    one, two = one[keep], two[keep]
    meet = np.minimum(high[one], high[two]) - np.maximum(low[one], low[two]) > TOLERANCE_M
    judged = _judged(scene.objects, by_name)
    worst: dict[tuple[int, int], tuple[float, float]] = {}
    for i, j, meets in zip(one.tolist(), two.tolist(), meet.tolist(), strict=True):
        a, b = int(owner[i]), int(owner[j])
        how = judged(a, b)
        if how == "owner" or (how == "apart" and not meets):
            continue
        distance = float(shapely.distance(seen[i], seen[j]))
        value = distance if distance > 0.0 else separation(parts[i][1].outline_m, parts[j][1].outline_m)
        least, deepest = worst.get((a, b), (np.inf, 0.0))
        worst[a, b] = (min(least, value), max(deepest, -value if meets else 0.0))
    names = [item.name for item in scene.objects]
    for (a, b), (value, depth) in sorted(worst.items()):
        if depth > TOLERANCE_M:
            yield Violation("penetration", (names[a], names[b]), depth, 0.0)
        elif value < scene.clearance_m - TOLERANCE_M:
            yield Violation("clearance", (names[a], names[b]), value, scene.clearance_m)


def _judged(
    objects: tuple[CheckObject, ...], by_name: dict[str, CheckObject]
) -> Callable[[int, int], Literal["owner", "whole", "apart"]]:
    """How two objects are judged: `owner` (not here), `whole` (of one place, heights overlap), `apart` (by prisms)."""
    spans = [(item.low_m, item.high_m) for item in objects]
    owners = [owners_of(item, by_name) for item in objects]

    def judged(a: int, b: int) -> Literal["owner", "whole", "apart"]:
        if objects[b].name in owners[a] or objects[a].name in owners[b]:
            return "owner"
        same = same_place(objects[a].place, objects[b].place) and overlap(spans[a], spans[b])
        return "whole" if same else "apart"

    return judged
