"""Outlines whose yaw is only known to lie in an interval: bounds of their support function, and the part surely
covered.

All outlines are convex, (n, 2), counter-clockwise, about the asset origin in the stance frame S. Each bound holds for
every yaw of the interval, so that proofs from it are never false.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely
from shapely import MultiPoint

from geom.planar import inner_radius, turned
from scenec.ir.problem import Thing
from schemas.arrays import FloatArray
from schemas.scene.geometry import Prism, Stance

TURN = 2.0 * np.pi
OUTLINE_SLACK_M = 2e-6
"""Every bound is weakened by this much: twice what the independent judge tolerates."""
SMALLEST_CELL_RAD = np.radians(0.25)
"""Searches halve yaw intervals down to this, then give up; 0.5 degrees proves the same 381 of 680 random programs."""
YawCell = tuple[float, float]


@lru_cache(maxsize=4096)
def _hull(key: bytes) -> FloatArray:
    ring = shapely.get_coordinates(MultiPoint(np.frombuffer(key).reshape(-1, 2)).convex_hull)[:-1]
    area = np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1))
    return ring if area > 0.0 else ring[::-1].copy()


def hull(prisms: tuple[Prism, ...]) -> FloatArray:
    """Convex hull (n, 2) of the outlines, counter-clockwise."""
    return _hull(np.ascontiguousarray(np.concatenate([prism.outline_m for prism in prisms])).tobytes())


def resting_orientations(thing: Thing) -> tuple[Stance, ...]:
    """The resting orientations that the thing may take."""
    return tuple(thing.body.resting_orientations[k] for k in thing.domain.orientation_indices)


def support_bounds(outline: FloatArray, direction: FloatArray, yaw: YawCell) -> tuple[float, float, float, float]:
    """(least front, greatest front, least back, greatest back): exact bounds over the yaw interval of the support
    function of the turned outline along a unit direction (2,), and against it.

    The support function is the maximum of one sinusoid per corner. Its extremes are at the ends of the interval, where
    an edge normal meets the direction, or where a corner meets the direction or its opposite.
    """
    return _support_bounds(outline.tobytes(), (float(direction[0]), float(direction[1])), yaw)[:4]


def least_width(outline: FloatArray, direction: FloatArray, yaw: YawCell) -> float:
    """Least extent along a unit direction over the yaw interval (exact: between yaws at which an edge normal meets the
    direction the extent is concave)."""
    return _support_bounds(outline.tobytes(), (float(direction[0]), float(direction[1])), yaw)[4]


@lru_cache(maxsize=65536)
def _support_bounds(
    key: bytes, direction: tuple[float, float], yaw: YawCell
) -> tuple[float, float, float, float, float]:
    """The four bounds of `support_bounds` and the least width; cached, since few outlines recur often."""
    outline = np.frombuffer(key).reshape(-1, 2)
    aim = np.arctan2(direction[1], direction[0])
    edges = np.roll(outline, -1, axis=0) - outline
    normal = np.arctan2(-edges[:, 0], edges[:, 1])
    corner = np.arctan2(outline[:, 1], outline[:, 0])
    turns = aim - np.concatenate([normal, normal + np.pi, corner, corner + np.pi])
    low, high = yaw
    past = (turns - low) % TURN
    angles = np.concatenate([[low, high], low + past[past <= high - low]])
    along = np.cos(angles - aim)[:, None] * outline[:, 0] - np.sin(angles - aim)[:, None] * outline[:, 1]
    front, back = along.max(axis=1), -along.min(axis=1)
    least = float((front + back).min())
    return float(front.min()), float(front.max()), float(back.min()), float(back.max()), least


def kernel(outline: FloatArray, yaw: YawCell) -> FloatArray:
    """Polygon (m, 2) inside the part that the outline covers at every yaw of the interval; (0, 2) when that is empty.

    The boundary of the region left by a turning edge is an arc, which is replaced by the chords of its two halves;
    these lie inside the arc, so that the result is still covered.
    """
    return _kernel(np.ascontiguousarray(outline).tobytes(), yaw)


@lru_cache(maxsize=4096)
def _kernel(key: bytes, yaw: YawCell) -> FloatArray:
    outline = np.frombuffer(key).reshape(-1, 2)
    middle, half = (yaw[0] + yaw[1]) / 2.0, (yaw[1] - yaw[0]) / 2.0
    if half < 1e-9:
        return turned(outline, middle)
    if half >= np.pi / 2.0:
        inner = inner_radius(outline)
        angles = np.arange(8) * (TURN / 8)
        return inner * np.stack([np.cos(angles), np.sin(angles)], axis=1) if inner > 0.0 else np.zeros((0, 2))
    edges = np.roll(outline, -1, axis=0) - outline
    angles = np.arctan2(-edges[:, 0], edges[:, 1])
    offsets = np.cos(angles) * outline[:, 0] + np.sin(angles) * outline[:, 1]
    inside = offsets > 0.0
    chord = offsets[inside] * np.cos(half / 2.0)
    turns = np.concatenate(
        [angles + half, angles - half, angles[inside] + half / 2.0, angles[inside] - half / 2.0, angles[inside]]
    )
    bounds = np.concatenate([offsets, offsets, chord, chord, offsets[inside]])
    return turned(half_planes(np.stack([np.cos(turns), np.sin(turns)], axis=1), bounds, outline), middle)


def half_planes(normals: FloatArray, bounds: FloatArray, start: FloatArray) -> FloatArray:
    """The part (m, 2) of a convex outline with normals @ p <= bounds; (0, 2) when it is empty."""
    ring = start
    for normal, bound in zip(normals, bounds, strict=True):
        over = ring @ normal - bound
        if (over <= 0.0).all():
            continue
        if (over >= 0.0).all():
            return np.zeros((0, 2))
        after, next_over = np.roll(ring, -1, axis=0), np.roll(over, -1)
        cut = (over < 0.0) & (next_over > 0.0) | (next_over < 0.0) & (over > 0.0)
        share = np.where(cut, over, 0.0) / np.where(cut, over - next_over, 1.0)
        points = np.stack([ring, ring + (after - ring) * share[:, None]], axis=1)
        ring = points[np.stack([over <= 0.0, cut], axis=1)]
    return ring


def period(outline: FloatArray) -> float:
    """The least fraction of 2 pi that turns the outline onto itself, within 0.5 um; 2 pi when there is none."""
    for parts in range(len(outline), 1, -1):
        if len(outline) % parts == 0:
            moved = turned(outline, TURN / parts)
            if np.abs(np.roll(outline, -(len(outline) // parts), axis=0) - moved).max() < OUTLINE_SLACK_M / 4.0:
                return TURN / parts
    return TURN
