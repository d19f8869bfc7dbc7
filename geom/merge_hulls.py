"""Fewer convex pieces: join neighbours whose common hull adds the least volume."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence

import numpy as np
from manifold3d import Manifold

from schemas.model import FloatArray

# Boxes of neighbours overlap once grown by this share of the whole.
NEIGHBOUR_SHARE = 0.01


def merge_hulls(
    pieces: Sequence[FloatArray], most: int, allowed: Callable[[FloatArray], bool] = lambda _: True
) -> list[FloatArray]:
    """At most `most` point sets (k_i, 3), whose hulls cover the hulls of `pieces`; more if `allowed` forbids the rest.

    Greedy, cheapest pair first; the cost is the volume that the common hull adds to the two. `allowed` gets the points
    of a merged piece and may refuse it, for instance because it would close an opening. Neighbours first; pieces that
    touch nothing join only when no neighbours are left.
    """
    if len(pieces) <= most:
        return list(pieces)
    for near_only in (True, False):
        pieces = _merged(pieces, most, allowed, near_only)
        if len(pieces) <= most:
            break
    return list(pieces)


def _merged(
    pieces: Sequence[FloatArray], most: int, allowed: Callable[[FloatArray], bool], near_only: bool
) -> list[FloatArray]:
    points = np.concatenate(pieces)
    reach = NEIGHBOUR_SHARE * float(np.ptp(points, axis=0).max())
    # A piece keeps its number for life; a merged one gets the next, so that the order is the same in every run.
    alive = dict(enumerate(pieces))
    volumes = {k: _hull(p).volume() for k, p in alive.items()}
    queue: list[tuple[float, int, int]] = []

    def offer(i: int, j: int) -> None:
        a, b = alive[i], alive[j]
        if not near_only or (np.minimum(a.max(0), b.max(0)) + reach >= np.maximum(a.min(0), b.min(0))).all():
            cost = _hull(np.concatenate([a, b])).volume() - volumes[i] - volumes[j]
            heapq.heappush(queue, (cost, i, j))

    for i in range(len(pieces)):
        for j in range(i):
            offer(j, i)
    following = len(pieces)
    while len(alive) > most and queue:
        _, i, j = heapq.heappop(queue)
        if i not in alive or j not in alive:
            continue
        hull = _hull(np.concatenate([alive[i], alive[j]]))
        corners = np.asarray(hull.to_mesh64().vert_properties)[:, :3]
        if not allowed(corners):
            continue
        del alive[i], alive[j]
        others = list(alive)
        alive[following], volumes[following] = corners, hull.volume()
        for k in others:
            offer(k, following)
        following += 1
    return list(alive.values())


def _hull(points: FloatArray) -> Manifold:
    return Manifold.hull_points(np.ascontiguousarray(points, dtype=np.float64))
