"""Outlines whose heading is only known to lie in an interval: least and greatest reach, and what is surely covered.

All outlines are convex, (n, 2), counter-clockwise, about the asset origin in the stance frame S. A bound given here
holds for every heading of the interval, so that what follows from it is never false.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely
from shapely import MultiPoint

from geom.planar import inner_radius, turned
from scenec.ir.problem import FloatArray, Slab, Stance, Thing

TURN = 2.0 * np.pi
SLACK_M = 2e-6
"""Every bound is weakened by this much: twice what the independent judge tolerates."""
YawCell = tuple[float, float]


@lru_cache(maxsize=4096)
def _hull(key: bytes) -> FloatArray:
    ring = shapely.get_coordinates(MultiPoint(np.frombuffer(key).reshape(-1, 2)).convex_hull)[:-1]
    area = np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1))
    return ring if area > 0.0 else ring[::-1].copy()


def hull(slabs: tuple[Slab, ...]) -> FloatArray:
    """Convex hull (n, 2) of the outlines, counter-clockwise."""
    return _hull(np.ascontiguousarray(np.concatenate([slab.outline_m for slab in slabs])).tobytes())


def resting_orientations(thing: Thing) -> tuple[Stance, ...]:
    """The stances that the thing may take."""
    return tuple(thing.body.resting_orientations[k] for k in thing.domain.orientation_indices)


def support_bounds(outline: FloatArray, direction: FloatArray, yaw: YawCell) -> tuple[float, float, float, float]:
    """(least front, greatest front, least back, greatest back): how far the outline turned by a heading of the interval
    reaches from its origin along a unit direction (2,), and against it. Exact.

    The reach is the greatest of sinusoids, one a corner; its extremes lie at the ends of the interval, where two
    corners change places (an edge normal meets the direction), or where a corner meets the direction or its opposite.
    """
    return _support_bounds(outline.tobytes(), (float(direction[0]), float(direction[1])), yaw)[:4]


def least_width(outline: FloatArray, direction: FloatArray, yaw: YawCell) -> float:
    """Least extent along a unit direction over the headings of the interval (exact: between its breakpoints, where an
    edge stands across the direction, the extent is concave)."""
    return _support_bounds(outline.tobytes(), (float(direction[0]), float(direction[1])), yaw)[4]


@lru_cache(maxsize=65536)
def _support_bounds(
    key: bytes, direction: tuple[float, float], yaw: YawCell
) -> tuple[float, float, float, float, float]:
    """The four bounds of `support_bounds` and the least width: the same few outlines are asked for again and again."""
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
    """What the outline covers at every heading of the interval, (m, 2); (0, 2) when it is nothing.

    An edge turned through the interval sweeps a half-plane; its farthest points run on an arc, which is replaced by the
    chords of two equal parts (inside the arc, so the answer is covered all the same).
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
    """The part (m, 2) of a convex outline with normals @ p <= bounds; (0, 2) when nothing is left."""
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
    """The least turn (a part of 2 pi) that maps the outline onto itself, to 1 um; 2 pi when there is none."""
    for parts in range(len(outline), 1, -1):
        if len(outline) % parts == 0:
            moved = turned(outline, TURN / parts)
            if np.abs(np.roll(outline, -(len(outline) // parts), axis=0) - moved).max() < SLACK_M / 4.0:
                return TURN / parts
    return TURN
