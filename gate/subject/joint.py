"""A joint between two bodies: the joint frame of each side in the world at rest, limits, rest coordinate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from gate.subject.body import Body
from geom.pose import shortest_rotation
from schemas.arrays import FloatArray

AXES = {"X": np.array([1.0, 0.0, 0.0]), "Y": np.array([0.0, 1.0, 0.0]), "Z": np.array([0.0, 0.0, 1.0])}
ONE_DOF_KINDS = ("revolute", "prismatic")


@dataclass(frozen=True)
class JointSide:
    """One end of a joint: the prim named (None = the world), the body that prim belongs to (None = static).

    `X_WJ` (4, 4) is the joint frame in the world as this side states it; NaN when it cannot be computed.
    """

    targets: tuple[str, ...]
    prim: Any
    body: Body | None
    X_WJ: FloatArray


@dataclass(frozen=True)
class Joint:
    """A joint prim.

    kind    revolute, prismatic, spherical, fixed, distance or generic.
    limits  (lower, upper) of a revolute (degrees) or prismatic (metres) joint; infinite where there is none.
    stated  for each limit, whether the file states it.
    """

    prim: Any
    kind: str
    enabled: bool
    axis: str
    sides: tuple[JointSide, JointSide]
    limits: tuple[float, float]
    stated: tuple[bool, bool]
    collides: bool
    in_articulation: bool

    @property
    def path(self) -> str:
        """The prim path."""
        return str(self.prim.GetPath())

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies it connects: two, or one that is fixed to the world."""
        return tuple(s.body for s in self.sides if s.body is not None)

    @property
    def size_m(self) -> float:
        """Diagonal of the larger of the joined bodies."""
        return max((b.diagonal_m for b in self.bodies), default=0.0)

    @property
    def unit(self) -> str:
        """Unit of its coordinate and limits."""
        return "deg" if self.kind == "revolute" else "m"

    def rest(self) -> JointRestState | None:
        """The relative pose of the two frames at rest; None when a frame is not finite."""
        X_W0, X_W1 = (side.X_WJ for side in self.sides)
        if not (np.all(np.isfinite(X_W0)) and np.all(np.isfinite(X_W1))):
            return None
        R_W0 = X_W0[:3, :3]
        shift = R_W0.T @ (X_W1[:3, 3] - X_W0[:3, 3])
        turn = R_W0.T @ X_W1[:3, :3]
        axis = AXES.get(self.axis, AXES["X"])
        if self.kind == "prismatic":
            along = float(axis @ shift)
            return JointRestState(along, float(np.linalg.norm(shift - along * axis)), _degrees(turn))
        gap_m = 0.0 if self.kind in ("distance", "generic") else float(np.linalg.norm(shift))
        if self.kind == "revolute":
            swing = shortest_rotation(axis, turn @ axis)
            twist = Rotation.from_matrix(swing.T @ turn).as_rotvec()
            return JointRestState(self._nearest_turn(float(np.rad2deg(axis @ twist))), gap_m, _degrees(swing))
        return JointRestState(0.0, gap_m, _degrees(turn) if self.kind == "fixed" else 0.0)

    def _nearest_turn(self, angle_deg: float) -> float:
        """The angle is known up to full turns: the one nearest to the limits."""
        lower, upper = self.limits
        if not lower <= upper:
            return angle_deg
        turns = [angle_deg + 360.0 * k for k in (0, -1, 1)]
        return min(turns, key=lambda angle: max(lower - angle, angle - upper, 0.0))


@dataclass(frozen=True)
class JointRestState:
    """Joint coordinate (degrees or metres) at rest, and the constraint violation: gap (m) and tilt (degrees)."""

    coordinate: float
    gap_m: float
    tilt_deg: float


def _degrees(turn: FloatArray) -> float:
    return float(np.rad2deg(Rotation.from_matrix(turn).magnitude()))
