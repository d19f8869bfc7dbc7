"""Greedy merging of convex bodies: neighbours whose common hull adds the least empty volume are joined first."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence

import numpy as np
from manifold3d import Manifold

# Boxes of neighbours overlap once grown by this share of the whole.
NEIGHBOUR_SHARE = 0.01


def merge_hulls(
    hulls: Sequence[Manifold], most: int, spare: float = 0.0, violation: Callable[[Manifold], float] = lambda _: 0.0
) -> list[Manifold]:
    """Convex bodies that cover `hulls`: at most `most` unless `violation` forbids the rest, fewer where it is cheap.

    Greedy, cheapest pair first; the cost is the volume that the common hull adds to the union of the two. `violation`
    rates a common hull: 1 doubles its cost, its square counts, infinity forbids it (it would close an opening).
    Beyond `most` pairs go on joining while all added volume together is at most `spare` and no violation exceeds 1.
    Neighbours first; pieces that touch nothing join only when there are still too many.
    """
    hulls = _merged(list(hulls), most, spare, violation, near_only=True)
    return hulls if len(hulls) <= most else _merged(hulls, most, 0.0, violation, near_only=False)


def _merged(
    hulls: list[Manifold], most: int, spare: float, violation: Callable[[Manifold], float], *, near_only: bool
) -> list[Manifold]:
    # A piece keeps its number for life; a merged one gets the next, so that the order is the same in every run.
    alive = dict(enumerate(hulls))
    boxes = {k: np.asarray(hull.bounding_box()) for k, hull in alive.items()}
    volumes = {k: hull.volume() for k, hull in alive.items()}
    all_boxes = np.array(list(boxes.values()))
    slack = NEIGHBOUR_SHARE * float((all_boxes[:, 3:].max(axis=0) - all_boxes[:, :3].min(axis=0)).max())
    # (cost, pair, what it adds, the common hull, whether the cost is final)
    queue: list[tuple[float, int, int, float, Manifold, bool]] = []

    def offer(i: int, j: int) -> None:
        a, b = boxes[i], boxes[j]
        if not near_only or (np.minimum(a[3:], b[3:]) + slack >= np.maximum(a[:3], b[:3])).all():
            common = Manifold.batch_hull([alive[i], alive[j]])
            added = common.volume() - volumes[i] - volumes[j]  # Too low where the two overlap.
            heapq.heappush(queue, (added, i, j, added, common, False))

    for i in range(len(hulls)):
        for j in range(i):
            offer(j, i)
    following = len(hulls)
    while queue and (len(alive) > most or spare > 0.0):
        _, i, j, added, common, is_final = heapq.heappop(queue)
        if i not in alive or j not in alive:
            continue
        if not is_final:
            added = max(added + (alive[i] ^ alive[j]).volume(), 0.0)
            violation_of_pair = violation(common)
            if np.isfinite(violation_of_pair) and (len(alive) > most or violation_of_pair <= 1.0):
                heapq.heappush(queue, (added * (1.0 + violation_of_pair**2), i, j, added, common, True))
            continue
        if len(alive) <= most:
            if added > spare:
                continue
            spare -= added
        del alive[i], alive[j]
        alive[following], boxes[following] = common, np.asarray(common.bounding_box())
        volumes[following] = common.volume()
        for k in list(alive)[:-1]:
            offer(k, following)
        following += 1
    return list(alive.values())
