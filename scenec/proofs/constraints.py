"""Constraints that proofs are made of: differences along an axis, and linear constraints of origins at a node of the
branch and bound. Lengths in metres, in the owner's frame P.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from scenec.proofs.outlines import YawCell, hull
from scenec.proofs.places import PlacementBounds
from schemas.arrays import FloatArray
from schemas.scene.geometry import Stance

BEGIN, ORIGIN, END = 0, 1, 2  # of a footprint along an axis


class Difference(NamedTuple):
    """v - u >= `least_m`, for points u and v of members by number: BEGIN, ORIGIN or END of their footprints."""

    member_u: int
    point_u: int
    member_v: int
    point_v: int
    least_m: float


@dataclass(frozen=True)
class NodePose:
    """Pose of one thing at a node: its orientation, interval of yaws in A, range of heights of its lowest point over
    the place; `at` is its origin in A at a fixed pose."""

    stance: Stance
    yaw: YawCell
    bounds: PlacementBounds
    base_m: tuple[float, float]
    at: FloatArray | None = None

    @property
    def key(self) -> tuple:
        """Identifies it among the poses of one thing."""
        return (self.yaw, self.stance.quat_wxyz, None if self.at is None else tuple(self.at.tolist()))

    @property
    def outline(self) -> FloatArray:
        """Convex hull (n, 2) of its footprint in S."""
        return hull(self.stance.prisms)


@dataclass(frozen=True)
class LinearConstraint:
    """normal @ (p_second - p_first) <= bound over origins in P; first or second is -1 for the owner's own origin."""

    first: int
    second: int
    normal: tuple[float, float]
    bound: float
