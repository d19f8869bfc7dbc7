"""Elongated ends of a solid that a hand can grip: the handle of a pan, a spoon or a hammer. Lengths in metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.mesh.surface_distance import sample_surface
from schemas.arrays import FloatArray, IntArray
from schemas.physics import Solid

END_SAMPLES, END_SLICES = 6000, 40
# Widths that a hand can close around, the shortest length, and how much thinner than the rest.
THICKEST_M, THINNEST_M, SHORTEST_M = 0.05, 0.005, 0.06
HANDLE_LEAST_SHARE, HANDLE_MOST_SHARE = 0.25, 0.93
HANDLE_WIDTH_SHARE = 0.55
EVEN = 2.0  # the widest slice over the narrowest: a cone is no grip


@dataclass(frozen=True)
class ElongatedEnd:
    """The axis of an end as points (k, 3) from the body to its free tip, and its greatest width."""

    axis_m: FloatArray
    width_m: float


def find_elongated_end(solid: Solid) -> ElongatedEnd | None:
    """The thin, even end along the longest principal axis, the longer one of two; None without any."""
    if solid.kind == "hull":
        return None
    points, _ = sample_surface(solid.points, solid.triangles, END_SAMPLES, 0)
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T[::-1]
    local = centred @ axes.T
    along = local[:, 0]
    length = float(np.ptp(along))
    if length < SHORTEST_M:
        return None
    slot = np.minimum(((along - along.min()) / length * END_SLICES).astype(int), END_SLICES - 1)
    widths, middles = np.zeros(END_SLICES), np.zeros((END_SLICES, 3))
    for k in range(END_SLICES):
        in_slice = local[slot == k]
        if len(in_slice) < 8:
            return None
        low, high = in_slice.min(axis=0), in_slice.max(axis=0)
        widths[k] = float((high - low)[1:].max())
        middles[k] = 0.5 * (low + high)
    body = float(widths.max())
    thin = (widths <= min(THICKEST_M, HANDLE_WIDTH_SHARE * body)) & (widths >= THINNEST_M)
    ends: list[tuple[float, IntArray]] = []
    for order in (np.arange(END_SLICES), np.arange(END_SLICES)[::-1]):
        # The outermost slice may be rounded off.
        run = int((~thin[order[1:]]).argmax()) + 1 if not thin[order[1:]].all() else END_SLICES
        inner = order[1:run]
        share = run / END_SLICES
        long_enough = run * length / END_SLICES >= SHORTEST_M and HANDLE_LEAST_SHARE <= share <= HANDLE_MOST_SHARE
        if long_enough and len(inner) and widths[inner].max() <= EVEN * widths[inner].min():
            ends.append((share, inner[::-1]))
    if not ends:
        return None
    _, slices = max(ends, key=lambda end: end[0])
    axis = middles[slices] @ axes + points.mean(axis=0)
    return ElongatedEnd(axis[:: max(1, len(axis) // 6)], float(widths[slices].max()))
