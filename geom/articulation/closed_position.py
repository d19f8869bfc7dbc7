"""The position of a joint at which the object is shut: where the box around the whole object is smallest.

A drawer, a door, a lid or a folding half takes least room when it is shut. Input: surface points (metres, one frame
with z up) of what moves and of what stays, and the motion; output: positions of the joint.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geom.articulation.moved_shape import box_around, level_heading
from geom.pose import apply
from schemas.arrays import FloatArray

RANGE_STEPS = 24  # positions over the range
# Positions whose box is larger than the smallest one by less than this share of the growth are shut, too.
TIE_SHARE = 0.05
# Of the smallest box: a growth below it says nothing. A door of a large kitchen may stay within the box.
LEAST_GROWTH = 0.02
BOTH_ENDS_SHARE = 0.3  # of the growth: where both ends grow that much, the joint opens both ways


@dataclass(frozen=True)
class ClosedPosition:
    """Where the joint is shut and fully open; `growth` of the box from shut to open, as a share of the smallest box.

    `both_ways`: it is shut between its ends and opens towards both; `open` is then the farther end.
    """

    closed: float
    open: float
    growth: float
    both_ways: bool


def closed_position(
    moved: FloatArray,
    fixed: FloatArray,
    motion: Callable[[float], FloatArray],
    limits: tuple[float, float],
    rest: float,
) -> ClosedPosition | None:
    """The shut and the open position within `limits`; None where the room that it takes hardly varies.

    `motion(q)` is the motion (4, 4) of the points `moved` (n, 3), given at `rest`, to the position q; `fixed` (m, 3)
    stays. The rest state is preferred among positions that are equally shut, then a limit.
    """
    low, high = limits
    positions = np.unique([*np.linspace(low, high, RANGE_STEPS + 1), min(max(rest, low), high)])
    heading = level_heading(fixed)
    boxes = np.array(
        [float(np.prod(box_around(np.concatenate([fixed, apply(motion(q), moved)]), heading))) for q in positions]
    )
    least, most = float(boxes.min()), float(boxes.max())
    growth = (most - least) / max(least, np.finfo(float).tiny)
    if growth < LEAST_GROWTH:
        return None
    shut = positions[boxes <= least + TIE_SHARE * (most - least)]
    closed = _preferred(shut, rest, low, high)
    at_low, at_high = float(boxes[0] - least), float(boxes[-1] - least)
    both = min(at_low, at_high) >= BOTH_ENDS_SHARE * (most - least) and low < closed < high
    opens_high = high - closed >= closed - low if both else at_high > at_low
    return ClosedPosition(closed, high if opens_high else low, growth, both)


def _preferred(shut: FloatArray, rest: float, low: float, high: float) -> float:
    """The rest state if it is among the shut positions (n,), else a limit, else their middle."""
    for position in (rest, low, high):
        if (np.abs(shut - position) <= 1e-9 * max(high - low, 1e-12)).any():
            return position
    return 0.5 * (float(shut.min()) + float(shut.max()))
