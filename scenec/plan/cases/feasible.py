"""Feasible area of cells: inside a place, clear of obstacles above it and of keep-outs. Exact for rectangles.

Rectangles are rows (x_low, x_high, y_low, y_high) in the owner's frame P, metres; all tests are for many at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from scenec.solve.model import Site
from scenec.solve.planar import SLACK_M, outline_of
from schemas.arrays import BoolArray, FloatArray

MOST_TRIANGLES = 24  # above this, notches of a place are replaced by their hulls: safe, but less area


@dataclass(frozen=True)
class Feasible:
    """A convex outline by its box (4,) and slanted edges (normals (e, 2), ends (e,)), less convex blocks (v, 2)."""

    box_m: FloatArray
    normals: FloatArray
    ends_m: FloatArray
    blocks: tuple[FloatArray, ...]

    def holds(self, rect_m: FloatArray) -> BoolArray:
        """(m,) whether each of the rectangles (m, 4) lies wholly inside."""
        x0, x1, y0, y1 = rect_m.T
        ax0, ax1, ay0, ay1 = self.box_m
        inside = (x0 >= ax0 - SLACK_M) & (x1 <= ax1 + SLACK_M) & (y0 >= ay0 - SLACK_M) & (y1 <= ay1 + SLACK_M)
        for (nx, ny), end in zip(self.normals, self.ends_m, strict=True):
            inside &= nx * (x1 if nx > 0 else x0) + ny * (y1 if ny > 0 else y0) <= end + SLACK_M
        for block in self.blocks:
            (bx0, by0), (bx1, by1) = block.min(axis=0), block.max(axis=0)
            apart = (x1 <= bx0 + SLACK_M) | (x0 >= bx1 - SLACK_M) | (y1 <= by0 + SLACK_M) | (y0 >= by1 - SLACK_M)
            for (nx, ny), end in zip(*_edges(block), strict=True):
                apart |= nx * (x0 if nx > 0 else x1) + ny * (y0 if ny > 0 else y1) >= end - SLACK_M
            inside &= apart
        return inside

    def limit(self, rect_m: FloatArray, side: int) -> FloatArray:
        """(m,) how far one side (0 x_low, 1 x_high, 2 y_low, 3 y_high) of valid rectangles (m, 4) may be moved out."""
        along, high = side // 2, side % 2 == 1
        low_m, high_m = rect_m[:, 2 - 2 * along], rect_m[:, 3 - 2 * along]
        out = np.full(len(rect_m), self.box_m[side])
        nearer = np.minimum if high else np.maximum
        for normal, end in zip(self.normals, self.ends_m, strict=True):
            n, m = normal[along], normal[1 - along]
            if (n > 0.0) == high and n != 0.0:
                out = nearer(out, (end - np.maximum(m * low_m, m * high_m)) / n)
        for block in self.blocks:
            near, far = _span_in_band(block, along, low_m, high_m)
            if high:
                out = np.where(near >= rect_m[:, side] - SLACK_M, np.minimum(out, near), out)
            else:
                out = np.where(far <= rect_m[:, side] + SLACK_M, np.maximum(out, far), out)
        return np.maximum(out, rect_m[:, side]) if high else np.minimum(out, rect_m[:, side])


def feasible_on(site: Site, height_m: float) -> Feasible:
    """Feasible area of a place for things up to `height_m` tall on its floor; frame P."""
    layers = [area for low, _, area in site.layers if low < height_m - SLACK_M] or [site.layers[0][2]]
    area: BaseGeometry = layers[0] if len(layers) == 1 else shapely.intersection_all(layers)
    low, high = site.base_P_m, site.base_P_m + height_m
    blocked = [
        outline
        for part, part_low, part_high in (*site.above, *site.keep_outs)
        if part_low < high - SLACK_M and part_high > low + SLACK_M
        for outline in _convex(part)
    ]
    if area.is_empty:
        return Feasible(np.array([1.0, -1.0, 1.0, -1.0]), np.zeros((0, 2)), np.zeros(0), ())
    hull = shapely.convex_hull(area)
    x0, y0, x1, y1 = hull.bounds
    normals, ends = _edges(outline_of(hull))
    slanted = np.abs(normals).max(axis=1) < 1.0 - 1e-12
    notches = shapely.difference(hull, area)
    if notches.area > 1e-12:
        blocked += _convex(notches)
    return Feasible(np.array([x0, x1, y0, y1]), normals[slanted], ends[slanted], tuple(blocked))


def _convex(area: BaseGeometry) -> list[FloatArray]:
    # Convex outlines that cover an area: itself, its triangles if few, else hulls of its parts.
    if shapely.convex_hull(area).area - area.area <= 1e-12:
        return [outline_of(shapely.convex_hull(area))]
    triangles = [p for p in shapely.get_parts(shapely.constrained_delaunay_triangles(area)).tolist() if p.area > 1e-12]
    if len(triangles) > MOST_TRIANGLES:
        parts = [p for p in shapely.get_parts(area).tolist() if p.area > 1e-12]
        return [outline_of(shapely.convex_hull(part)) for part in parts]
    return [outline_of(shapely.convex_hull(triangle)) for triangle in triangles]


def _edges(outline: FloatArray) -> tuple[FloatArray, FloatArray]:
    # Outward unit normals (e, 2) of a counter-clockwise outline and their offsets (e,).
    step = np.roll(outline, -1, axis=0) - outline
    length = np.hypot(*step.T)
    step, start = step[length > 1e-12] / length[length > 1e-12, None], outline[length > 1e-12]
    normals = np.stack([step[:, 1], -step[:, 0]], axis=1)
    return normals, (normals * start).sum(axis=1)


def _span_in_band(
    outline: FloatArray, along: int, low_m: FloatArray, high_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    # Least and greatest coordinate `along` of a convex outline between two others (m,) across; (inf, -inf) if outside.
    at, across = outline[:, along], outline[:, 1 - along]
    inside = (across > low_m[:, None] + SLACK_M) & (across < high_m[:, None] - SLACK_M)
    least = np.where(inside, at, np.inf).min(axis=1)
    most = np.where(inside, at, -np.inf).max(axis=1)
    next_at, next_across = np.roll(at, -1), np.roll(across, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        for border in (low_m + SLACK_M, high_m - SLACK_M):
            share = (border[:, None] - across) / (next_across - across)
            met = (share >= 0.0) & (share <= 1.0)
            crossing = at + share * (next_at - at)
            least = np.minimum(least, np.where(met, crossing, np.inf).min(axis=1))
            most = np.maximum(most, np.where(met, crossing, -np.inf).max(axis=1))
    return least, most
