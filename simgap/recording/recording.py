"""Recorded trials and their columns in canonical names, SI units and frames."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from schemas.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Trial:
    """One time series. Every column is there with n rows; what was not measured is NaN (see `has`).

    t_s          (n,) strictly increasing, 0 at the first row; `t0_s` is the first stamp as recorded.
    p            (n, 3) origin of the body frame in the world, m.
    quat_wxyz    (n, 4) body to world, unit, without sign flips.
    v_W, w_B     (n, 3) velocity of that origin in world axes, m/s; angular velocity in BODY axes, rad/s.
    q, qd        (n, j) joints in the order of `Measurement.joints`, unwrapped rad (or m), rad/s (or m/s).
    effort       (n, j) as logged, in units of `actuation.effort_per_unit`.
    command      (n, j) commanded joint positions.
    command_p, command_quat_wxyz   (n, 3), (n, 4) commanded pose of the end effector.
    aux          (n,) side channels by their names in `aux`, e.g. `supply_V`.
    dropped      rows of the file that are not here (not finite, corrupted, stamped twice).
    file         where it was read from, relative to the folder.
    """

    id: str
    t_s: FloatArray
    p: FloatArray
    quat_wxyz: FloatArray
    v_W: FloatArray
    w_B: FloatArray
    q: FloatArray
    qd: FloatArray
    effort: FloatArray
    command: FloatArray
    command_p: FloatArray
    command_quat_wxyz: FloatArray
    aux: dict[str, FloatArray] = field(default_factory=dict)
    t0_s: float = 0.0
    dropped: int = 0
    file: str = ""

    def __len__(self) -> int:
        return len(self.t_s)

    def has(self, column: str) -> bool:
        """Whether anything was measured for that field, e.g. `has("v_W")`."""
        return bool(np.isfinite(getattr(self, column)).any())

    def rows(self, keep: BoolArray | IntArray) -> Trial:
        """The trial with the rows of a mask or an order of row numbers."""
        columns = {name: getattr(self, name)[keep] for name in COLUMNS}
        gone = len(self) - len(self.t_s[keep])
        return replace(self, **columns, aux={k: v[keep] for k, v in self.aux.items()}, dropped=self.dropped + gone)


COLUMNS = (
    "t_s",
    "p",
    "quat_wxyz",
    "v_W",
    "w_B",
    "q",
    "qd",
    "effort",
    "command",
    "command_p",
    "command_quat_wxyz",
)


@dataclass(frozen=True)
class Impacts:
    """Planar impacts, one row each: pose (x, y, angle) and velocity (vx, vy, angular rate) just before and after.

    normal, tangent   (n, 3) Jacobians of the contact point: `normal @ velocity` is its speed along the normal (positive
                      when parting), `tangent @ velocity` along the surface.
    """

    ids: tuple[str, ...]
    pose_before: FloatArray
    velocity_before: FloatArray
    pose_after: FloatArray
    velocity_after: FloatArray
    normal: FloatArray
    tangent: FloatArray

    def __len__(self) -> int:
        return len(self.ids)


@dataclass(frozen=True)
class Push:
    """One push: the body's pose before and after, the tip's path and the force on it, each with a clock of its own.

    before_p, after_p (3,) m and before_quat_wxyz, after_quat_wxyz (4,): body in the world.
    tip_t_s (n,), tip_p (n, 3) m, tip_quat_wxyz (n, 4): the pusher; NaN where only positions were recorded.
    force_t_s (m,), force (m, 2 or 3) N: force of the pusher ON the body, world axes.
    """

    id: str
    before_p: FloatArray
    before_quat_wxyz: FloatArray
    after_p: FloatArray
    after_quat_wxyz: FloatArray
    tip_t_s: FloatArray
    tip_p: FloatArray
    tip_quat_wxyz: FloatArray
    force_t_s: FloatArray
    force: FloatArray
