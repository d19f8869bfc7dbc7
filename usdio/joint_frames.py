"""Axes of UsdPhysics joints by their tokens, and positions of joints from their two frames."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray

AXES: Final = {"X": np.array([1.0, 0.0, 0.0]), "Y": np.array([0.0, 1.0, 0.0]), "Z": np.array([0.0, 0.0, 1.0])}


def joint_position(kind: str, axis: FloatArray, X_01: FloatArray, limits: tuple[float, float] | None) -> float:
    """The position (rad, or the unit of X_01) of a joint whose second frame is at X_01 (4, 4) in its first.

    Of hinges the turn about `axis` (3,) nearest to X_01, and of the angles of that turn the one nearest to `limits`;
    0 for joints of other kinds than revolute and prismatic.
    """
    if kind == "prismatic":
        return float(axis @ X_01[:3, 3])
    if kind != "revolute":
        return 0.0
    quat = Rotation.from_matrix(X_01[:3, :3]).as_quat()
    angle = math.remainder(2.0 * math.atan2(float(axis @ quat[:3]), float(quat[3])), math.tau)
    if limits is None:
        return angle
    lower, upper = limits
    turns = [angle + k * math.tau for k in (0, -1, 1)]
    return min(turns, key=lambda turn: max(lower - turn, turn - upper, 0.0))
