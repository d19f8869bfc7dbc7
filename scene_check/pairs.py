"""Two objects that are not each other's owners: clearance and penetration."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from scene_check.measures import overlap, polygons, separation
from scene_check.model import TOLERANCE_M, CheckObject, CheckScene, Violation, owners_of, same_place


def too_close(scene: CheckScene, by_name: dict[str, CheckObject], changed: frozenset[str]) -> Iterator[Violation]:
    """Clearance and penetration between objects that are not each other's owners, one of them among `changed`."""
    moved = np.array([item.name in changed for item in scene.objects], dtype=bool)
    near = _near(scene, moved)
    parts = [(k, prism) for k in np.flatnonzero(near).tolist() for prism in scene.objects[k].prisms]
    if not parts:
        return
    owner = np.array([k for k, _ in parts])
    low, high = np.array([p.low_m for _, p in parts]), np.array([p.high_m for _, p in parts])
    seen = polygons([p.outline_m for _, p in parts])
    moved = moved[owner]
    asking = np.flatnonzero(moved)
    reach = scene.clearance_m + TOLERANCE_M
    boxes = shapely.bounds(seen[asking]) + np.array([-reach, -reach, reach, reach])
    one, two = shapely.STRtree(seen).query(shapely.box(*boxes.T))
    one = asking[one]
    # Of two that changed each finds the other: the pair counts once, the earlier object first.
    keep = (owner[one] < owner[two]) | ((owner[one] > owner[two]) & ~moved[two])
    one, two = one[keep], two[keep]
    keep = shapely.dwithin(seen[one], seen[two], scene.clearance_m)
    one, two = one[keep], two[keep]
    one, two = np.where(owner[one] < owner[two], (one, two), (two, one))
    meet = np.minimum(high[one], high[two]) - np.maximum(low[one], low[two]) > TOLERANCE_M
    worst: dict[tuple[int, int], tuple[float, float]] = {}
    for i, j, meets in zip(one.tolist(), two.tolist(), meet.tolist(), strict=True):
        a, b = int(owner[i]), int(owner[j])
        how = _judged(scene.objects[a], scene.objects[b], by_name)
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


def _near(scene: CheckScene, moved: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which objects (n,) changed, or come with their bounding boxes within the clearance of one that did."""
    box = np.array([item.box_m for item in scene.objects]).reshape(-1, 4)
    reach, far = scene.clearance_m + 2.0 * TOLERANCE_M, box[moved]
    meet = (box[:, None, :2] <= far[None, :, 2:] + reach) & (far[None, :, :2] <= box[:, None, 2:] + reach)
    return moved | np.any(np.all(meet, axis=2), axis=1)


def _judged(one: CheckObject, two: CheckObject, by_name: dict[str, CheckObject]) -> Literal["owner", "whole", "apart"]:
    """How two objects are judged: `owner` (not here), `whole` (of one place, heights overlap), `apart` (by prisms)."""
    if two.name in owners_of(one, by_name) or one.name in owners_of(two, by_name):
        return "owner"
    same = same_place(one.place, two.place) and overlap((one.low_m, one.high_m), (two.low_m, two.high_m))
    return "whole" if same else "apart"
