"""How far a body that stands on level ground can be tilted, and loaded, before it tips over; lengths in metres.

Both follow from the lever arm of the weight: how fast the mass centre rises when the body leans to a side (the slope of
`centre_heights`). Tilted ground pulls it over when the tangent of the tilt exceeds lever arm over height; a load beside
the foot has a negative lever arm of its own, and that of body and load is their mean by mass.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.convex.support_function import centre_heights, support
from geom.pose import shortest_rotation
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

_HEADINGS = 72  # A corner of the foot lies within 2.5 degrees of one: its lever arm is right to a thousandth.
_LEAN_RAD = np.radians(0.5)


def tipping_angle(
    shapes: Sequence[CollisionShape], centre_m: FloatArray, down_A: FloatArray, lean_rad: float
) -> tuple[float, FloatArray]:
    """The steepest ground (rad) that a body stands on with `down_A` (3,) down, in the worst heading, without sliding,
    and the unit vector (3,) in its frame, across `down_A`, towards which it tips.

    What has a round foot may lean by up to `lean_rad` on the way; 0 for what rolls, negative for what falls over.
    """
    sides = _sides(down_A)
    leans: FloatArray = np.arange(-1.0, 1.0 + lean_rad / _LEAN_RAD) * _LEAN_RAD
    leans[:2] = 0.0, 0.1 * _LEAN_RAD
    downs = np.cos(leans)[:, None, None] * down_A + np.sin(leans)[:, None, None] * sides
    rises = centre_heights(shapes, centre_m, downs.reshape(-1, 3)).reshape(len(leans), _HEADINGS)
    lever = np.diff(rises, axis=0) / np.diff(leans)[:, None]
    steepest = np.arctan2(lever, 0.5 * (rises[1:] + rises[:-1])).max(axis=0)
    weakest = int(steepest.argmin())
    return float(steepest[weakest]), sides[weakest]


def tipping_loads(
    shapes: Sequence[CollisionShape], mass_kg: float, centre_m: FloatArray, down_A: FloatArray, at_m: FloatArray
) -> FloatArray:
    """The masses (k,) in kg at points (k, 3) of the body that tip it over; infinite over its foot, 0 if it falls alone.

    It stands with `down_A` (3,) down; its own mass centre is `centre_m` (3,).
    """
    sides = _sides(down_A)
    tipped = np.cos(_LEAN_RAD) * down_A + np.sin(_LEAN_RAD) * sides
    rise = support(shapes, tipped) - support(shapes, down_A[None])

    def levers(points_m: FloatArray) -> FloatArray:
        """(n, sides) of points (n, 3)."""
        return (rise - points_m @ (tipped - down_A).T) / np.sin(_LEAN_RAD)

    own, loads = np.maximum(levers(centre_m[None])[0], 0.0), levers(np.atleast_2d(at_m))
    masses = np.full(loads.shape, np.inf)
    np.divide(mass_kg * own, -loads, out=masses, where=loads < 0.0)
    return masses.min(axis=1)


def _sides(down_A: FloatArray) -> FloatArray:
    """Unit vectors (72, 3) across `down_A`, all around."""
    angles = np.arange(_HEADINGS) * (2.0 * np.pi / _HEADINGS)
    level = np.stack([np.cos(angles), np.sin(angles), np.zeros(_HEADINGS)], axis=1)
    return level @ shortest_rotation(np.array([0.0, 0.0, -1.0]), down_A).T
