"""Least distance (m) between a body along its path and a static shape, by branch and bound over time.

A block of times is left out where its middle is proved to be farther away than the bound by more than any point of the
body moves within the block; else it is split. What remains are single times, at which the distance is computed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from replay.verification.separation import DistanceShape, box_W, centre_and_radius, separation_m
from schemas.arrays import FloatArray, IntArray

BRANCHES = 8


@dataclass(frozen=True)
class StaticShape:
    """A shape of an inserted object at its pose, and its box in W."""

    distance_shape: DistanceShape
    X_WA: FloatArray
    low_W: FloatArray
    high_W: FloatArray


@dataclass(frozen=True)
class MovingShape:
    """A shape along poses X_WB (k, 4, 4), with a ball around it.

    centres_W (k, 3), radius of that ball. spread_m: for each level l the blocks of 8^l times, how far any point of the
    body is at most from where it is in the middle of the block.
    """

    distance_shape: DistanceShape
    X_WB: FloatArray
    centres_W: FloatArray
    radius_m: float
    motion_bound_m: tuple[FloatArray, ...]


def static_shape(distance_shape: DistanceShape, X_WA: FloatArray) -> StaticShape:
    """The shape at its pose, with its box in W."""
    return StaticShape(distance_shape, X_WA, *box_W(distance_shape, X_WA))


def moving_shape(distance_shape: DistanceShape, X_WB: FloatArray) -> MovingShape:
    """The shape along its poses; blocks up to the whole path."""
    centre, radius = centre_and_radius(distance_shape)
    centres = X_WB[:, :3, :3] @ centre + X_WB[:, :3, 3]
    spread, size = [np.zeros(len(X_WB))], 1
    while size < len(X_WB):
        size *= BRANCHES
        spread.append(_spread(X_WB, centres, radius, size))
    return MovingShape(distance_shape, X_WB, centres, radius, tuple(spread))


def _spread(X_WB: FloatArray, centres: FloatArray, radius: float, size: int) -> FloatArray:
    n = len(X_WB)
    middle = _middle(np.arange(-(-n // size)), size, n)
    at = np.repeat(middle, size)[:n]
    shift = np.linalg.norm(centres - centres[at], axis=1)
    # A rotation by an angle has Frobenius distance sqrt 8 sin(angle / 2) from none and moves by 2 r sin(angle / 2).
    turn = np.linalg.norm(X_WB[:, :3, :3] - X_WB[at, :3, :3], axis=(1, 2)) / np.sqrt(2.0)
    return np.maximum.reduceat(shift + radius * turn, np.arange(0, n, size))


def _middle(block: IntArray, size: int, n: int) -> IntArray:
    first = block * size
    return first + (np.minimum(first + size, n) - first) // 2


def least_distance(moving: MovingShape, static: StaticShape, at_most_m: float) -> tuple[float, int]:
    """The least distance and the row of the path where it is; `at_most_m` and -1 where it is no smaller than that."""
    best, row = at_most_m, -1
    n, top = len(moving.X_WB), len(moving.motion_bound_m) - 1
    todo = [(top, 0)]
    while todo and best > 0.0:
        level, block = todo.pop()
        middle = int(_middle(np.array(block), BRANCHES**level, n))
        slack = float(moving.motion_bound_m[level][block])
        if _box_distance_bound(moving, middle, static) - slack >= best:
            continue
        distance = separation_m(moving.distance_shape, moving.X_WB[middle], static.distance_shape, static.X_WA)
        if distance < best:
            best, row = distance, middle
        if level > 0 and distance - slack < best:
            children = range(BRANCHES * block, min(BRANCHES * (block + 1), -(-n // BRANCHES ** (level - 1))))
            todo += [(level - 1, child) for child in children]
    return best, row


def _box_distance_bound(moving: MovingShape, row: int, static: StaticShape) -> float:
    """Lower bound on the distance of the moving body from the box of the static shape."""
    centre = moving.centres_W[row]
    outside = np.maximum(np.maximum(static.low_W - centre, centre - static.high_W), 0.0)
    return float(np.sqrt(outside @ outside)) - moving.radius_m
