"""Planar poses of placed things: from the frame of their owner (P) up to that of the background (B); metres,
radians."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, sin
from typing import NamedTuple

from scenec.solve.placed import Placed
from schemas.scene.geometry import BACKGROUND


class Pose2(NamedTuple):
    """A frame in B: origin (x, y, z) and heading."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float

    def point(self, x_m: float, y_m: float) -> tuple[float, float]:
        """A point of this frame, in B."""
        c, s = cos(self.yaw_rad), sin(self.yaw_rad)
        return self.x_m + c * x_m - s * y_m, self.y_m + s * x_m + c * y_m

    def inverse_point(self, x_m: float, y_m: float) -> tuple[float, float]:
        """A point of B, in this frame."""
        c, s = cos(self.yaw_rad), sin(self.yaw_rad)
        dx, dy = x_m - self.x_m, y_m - self.y_m
        return c * dx + s * dy, -s * dx + c * dy


AT_BACKGROUND = Pose2(0.0, 0.0, 0.0, 0.0)


def pose_of(name: str, assignment: Mapping[str, Placed]) -> Pose2:
    """Asset frame of a placed thing in B. An owner that is not placed has the identity pose: relations among its
    contents alone do not depend on its pose."""
    if name == BACKGROUND or name not in assignment:
        return AT_BACKGROUND
    placed = assignment[name]
    owner = pose_of(placed.parent, assignment)
    x, y = owner.point(placed.x_P_m, placed.y_P_m)
    z = owner.z_m + placed.base_P_m + placed.turned.shape.origin_height_m
    return Pose2(x, y, z, owner.yaw_rad + placed.turned.yaw_rad)


def turned_direction(direction: tuple[float, float], yaw_rad: float) -> tuple[float, float]:
    """A direction turned by a yaw."""
    if yaw_rad == 0.0:
        return direction
    c, s = cos(yaw_rad), sin(yaw_rad)
    return c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]
