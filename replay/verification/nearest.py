"""Least distance between a body along its path and shapes that stand, by branch and bound over time.

A block of times is left out where its middle is proved to be farther away than asked by more than any point of the body
moves within the block; else it is split. What remains are single times, at which the distance is computed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from replay.verification.separation import Solid, box_W, centre_and_radius, separation_m
from schemas.model import FloatArray

BRANCHES = 8


@dataclass(frozen=True)
class Standing:
    """A shape of an inserted object at its pose, and its box in W."""

    solid: Solid
    X_WA: FloatArray
    low_W: FloatArray
    high_W: FloatArray


@dataclass(frozen=True)
class Path:
    """A shape along poses X_WB (k, 4, 4), with a ball around it.

    centres_W (k, 3), radius of that ball. spread_m: for each level l the blocks of 8^l times, how far any point of the
    body is at most from where it is in the middle of the block.
    """

    solid: Solid
    X_WB: FloatArray
    centres_W: FloatArray
    radius_m: float
    spread_m: tuple[FloatArray, ...]


def standing(solid: Solid, X_WA: FloatArray) -> Standing:
    """The shape where it stands."""
    return Standing(solid, X_WA, *box_W(solid, X_WA))


def path(solid: Solid, X_WB: FloatArray) -> Path:
    """The shape along its poses; blocks up to the whole path."""
    centre, radius = centre_and_radius(solid)
    centres = X_WB[:, :3, :3] @ centre + X_WB[:, :3, 3]
    spread, size = [np.zeros(len(X_WB))], 1
    while size < len(X_WB):
        size *= BRANCHES
        spread.append(_spread(X_WB, centres, radius, size))
    return Path(solid, X_WB, centres, radius, tuple(spread))


def _spread(X_WB: FloatArray, centres: FloatArray, radius: float, size: int) -> FloatArray:
    n = len(X_WB)
    middle = _middle(np.arange(-(-n // size)), size, n)
    at = np.repeat(middle, size)[:n]
    shift = np.linalg.norm(centres - centres[at], axis=1)
    # A rotation by an angle has Frobenius distance sqrt 8 sin(angle / 2) from none and moves by 2 r sin(angle / 2).
    turn = np.linalg.norm(X_WB[:, :3, :3] - X_WB[at, :3, :3], axis=(1, 2)) / np.sqrt(2.0)
    return np.maximum.reduceat(shift + radius * turn, np.arange(0, n, size))


def _middle(block: FloatArray, size: int, n: int) -> FloatArray:
    first = block * size
    return first + (np.minimum(first + size, n) - first) // 2


def least_distance(moving: Path, still: Standing, at_most_m: float) -> tuple[float, int]:
    """The least distance and the row of the path where it is; `at_most_m` and -1 where it is no smaller than that."""
    best, row = at_most_m, -1
    n, top = len(moving.X_WB), len(moving.spread_m) - 1
    todo = [(top, 0)]
    while todo and best > 0.0:
        level, block = todo.pop()
        middle = int(_middle(np.array(block), BRANCHES**level, n))
        slack = float(moving.spread_m[level][block])
        if _ball_gap(moving, middle, still) - slack >= best:
            continue
        distance = separation_m(moving.solid, moving.X_WB[middle], still.solid, still.X_WA)
        if distance < best:
            best, row = distance, middle
        if level > 0 and distance - slack < best:
            children = range(BRANCHES * block, min(BRANCHES * (block + 1), -(-n // BRANCHES ** (level - 1))))
            todo += [(level - 1, child) for child in children]
    return best, row


def _ball_gap(moving: Path, row: int, still: Standing) -> float:
    """At most the distance of the body from the box of what stands."""
    centre = moving.centres_W[row]
    outside = np.maximum(np.maximum(still.low_W - centre, centre - still.high_W), 0.0)
    return float(np.sqrt(outside @ outside)) - moving.radius_m
