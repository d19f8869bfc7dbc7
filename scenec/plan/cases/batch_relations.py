"""Evaluates relations on many layouts at once, with rectangles instead of footprints, to reject draws early.

`before` and `far_from` of rectangles imply those of footprints; `near` of rectangles is only necessary, and exact
later. Frame P of the owner, metres and radians.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from scenec.ir.problem import RelationIR
from scenec.solve.relations import SLACK
from scenec.solve.shelf import AXIS
from schemas.arrays import BoolArray, FloatArray


def may_hold(
    rule: RelationIR, rects_m: list[FloatArray], origins_m: list[FloatArray], fronts_rad: list[FloatArray]
) -> BoolArray:
    """Whether a rule may hold for its things in their order: rectangles (..., 4), origins (..., 2), headings (...)."""
    if rule.kind == "before":
        end = extent(rects_m[0], rule.direction)[1]
        begin = extent(rects_m[1], rule.direction)[0]
        return end + rule.gap_m <= begin + SLACK
    if rule.kind in ("near", "far_from"):
        gap = distance(rects_m[0], rects_m[1])
        return gap <= rule.gap_m + SLACK if rule.kind == "near" else gap >= rule.gap_m - SLACK
    if rule.kind == "aligned":
        dx, dy = rule.direction
        across = np.stack([-dy * o[..., 0] + dx * o[..., 1] for o in origins_m])
        return across.max(axis=0) - across.min(axis=0) <= rule.tolerance + SLACK
    if rule.kind == "facing":
        toward = origins_m[1] - origins_m[0]
        heading = np.arctan2(toward[..., 1], toward[..., 0])
        away = np.abs(wrapped_all(heading - fronts_rad[0]))
        return (away <= rule.tolerance + SLACK) & (np.hypot(toward[..., 0], toward[..., 1]) > 1e-4)
    line = origins_m[2] - origins_m[1]  # between
    length = np.maximum(np.hypot(line[..., 0], line[..., 1]), 1e-6)
    step = origins_m[0] - origins_m[1]
    along = (step * line).sum(axis=-1) / length
    beside = np.abs(step[..., 0] * line[..., 1] - step[..., 1] * line[..., 0]) / length
    return (along >= 0.0) & (along <= length) & (beside <= rule.tolerance + SLACK)


class AxisOrder(NamedTuple):
    """Member `first` ends `gap_m` before member `second` begins, along axis 0 (x) or 1 (y)."""

    first: int
    second: int
    along: int
    gap_m: float


def axis_orders(rules: Sequence[RelationIR], number: Mapping[str, int]) -> list[AxisOrder]:
    """The `before` relations along an axis, of members by number; those against an axis are reversed."""
    orders = []
    for rule in rules:
        along = axis_of(rule.direction)
        if rule.kind == "before" and along is not None:
            ends = [number[name] for name in rule.things]
            first, second = ends if rule.direction[along] > 0.0 else ends[::-1]
            orders.append(AxisOrder(first, second, along, rule.gap_m))
    return orders


def axis_of(direction: tuple[float, float]) -> int | None:
    """0 for a direction along x, 1 for one along y, None for any other."""
    return next((axis for axis in (0, 1) if abs(direction[axis]) > AXIS), None)


def wrapped_all(angle_rad: FloatArray) -> FloatArray:
    """Angles brought into [-pi, pi)."""
    return (angle_rad + np.pi) % (2.0 * np.pi) - np.pi


def extent(rect_m: FloatArray, direction: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Where rectangles (..., 4) begin and end along a direction."""
    dx, dy = direction
    x_first, y_first = (0, 1) if dx >= 0 else (1, 0), (2, 3) if dy >= 0 else (3, 2)
    low = dx * rect_m[..., x_first[0]] + dy * rect_m[..., y_first[0]]
    return low, dx * rect_m[..., x_first[1]] + dy * rect_m[..., y_first[1]]


def distance(one_m: FloatArray, two_m: FloatArray) -> FloatArray:
    """Distance of rectangles (..., 4)."""
    dx = np.maximum(np.maximum(two_m[..., 0] - one_m[..., 1], one_m[..., 0] - two_m[..., 1]), 0.0)
    dy = np.maximum(np.maximum(two_m[..., 2] - one_m[..., 3], one_m[..., 2] - two_m[..., 3]), 0.0)
    return np.hypot(dx, dy)
