"""Sine and cosine of half a yaw (rad), computed by additions, products and square roots alone.

These round alike on every machine (IEEE 754), while library functions differ in the last bit: samples have the same
bits everywhere.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

_TURNS_PER_RAD = 1.0 / (2.0 * math.pi)


def _taylor_coefficients(count: int) -> tuple[float, ...]:
    """Taylor coefficients of sin(r pi/2) in r^2, by products alone: a library's power may round differently."""
    quarter, term = math.pi / 2.0, math.pi / 2.0
    terms: list[float] = []
    for k in range(count):
        terms.append(term)
        term = -term * quarter * quarter / ((2 * k + 2) * (2 * k + 3))
    return tuple(terms)


_COEFFICIENTS = _taylor_coefficients(8)  # for |r| <= 1/2 the first term left out is below 5e-17


def half_angle(xp: ModuleType, yaw_rad: Any) -> tuple[Any, Any]:
    """Cosine and sine of half the yaw, brought to (-pi, pi] before: the scalar and z part of its quaternion."""
    turns = yaw_rad * _TURNS_PER_RAD
    turns -= xp.round(turns)
    square = turns * turns
    quarter = square * _COEFFICIENTS[-1]
    for term in _COEFFICIENTS[-2:0:-1]:
        quarter += term
        quarter *= square
    quarter += _COEFFICIENTS[0]
    quarter *= turns  # sine of a quarter of the yaw, at most sin(pi/4): its cosine is safe to take by the root
    square = quarter * quarter
    sine = xp.sqrt(1.0 - square)
    sine *= quarter
    sine *= 2.0
    square *= -2.0
    square += 1.0
    return square, sine
