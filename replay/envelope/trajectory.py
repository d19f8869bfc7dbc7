"""Trajectories of a robot between its recorded states (rad, m), with bounds on the deviation of joints.

The motion between two rows is unknown. Two interpolations are covered: linear in joint space, and the cubic Hermite
that also has the recorded rates. A `Trajectory` is a chain of states joined linearly in joint space, with a bound on
the deviation of each joint; where the Hermite curve deviates too far it gets a trajectory of its own.

Bounds. Hermite less linear is s (1-s)^2 a - s^2 (1-s) b with a = h v0 - dq and b = h v1 - dq: at most 4/27 (|a| + |b|).
A cubic deviates from its chord over a part ds by at most ds^2 / 8 times its largest second derivative, which is linear
in s and so largest at an end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from replay.recording.episode import FreeBody, Link, Robot
from schemas.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Trajectory:
    """States joined linearly: stamps t_s (m,), q (m, j), X_WR (m, 4, 4); bound `deviation` (m-1, j) of joints."""

    t_s: FloatArray
    q: FloatArray
    X_WR: FloatArray
    deviation: FloatArray


def as_robot(body: FreeBody) -> Robot:
    """A free body as a robot of one link on a moving base."""
    link = Link(body.name, -1, "fixed", np.array([0.0, 0.0, 1.0]), np.eye(4), shapes=body.shapes)
    return Robot(body.name, (link,), (), body.X_WB, np.zeros((len(body.X_WB), 0)))


def recorded_trajectory(robot: Robot, t_s: FloatArray) -> Trajectory:
    """The recorded states, with the Hermite curve within `deviation`."""
    return Trajectory(t_s, robot.q, robot.X_WR, _hermite_deviation(robot, t_s))


def refined_trajectories(robot: Robot, t_s: FloatArray, parts: IntArray, hermite_parts: IntArray) -> list[Trajectory]:
    """The linear trajectory with interval k in `parts[k]` parts, and one for each run of intervals whose Hermite curve
    is divided, in `hermite_parts[k]` parts (0: it stays within the deviation of the linear trajectory)."""
    deviation = np.where((hermite_parts > 0)[:, None], 0.0, _hermite_deviation(robot, t_s))
    at = _fractional_rows(0, parts)
    trajectories = [
        Trajectory(_stamps(t_s, at), _linear(robot.q, at), base_poses(robot.X_WR, at), deviation[at[:-1].astype(int)])
    ]
    for run in np.split(np.arange(len(hermite_parts)), np.flatnonzero(np.diff(hermite_parts > 0)) + 1):
        if len(run) and hermite_parts[run[0]] > 0:
            at = _fractional_rows(int(run[0]), hermite_parts[run])
            curve = _Hermite(robot, t_s)
            trajectories.append(
                Trajectory(_stamps(t_s, at), curve.q(at), base_poses(robot.X_WR, at), curve.deviation(at))
            )
    return trajectories


def at_fractional_rows(robot: Robot, t_s: FloatArray, at: FloatArray) -> Trajectory:
    """The linear trajectory through fractional rows (row + share), without any deviation."""
    deviation = np.zeros((max(len(at) - 1, 0), robot.q.shape[1]))
    return Trajectory(_stamps(t_s, at), _linear(robot.q, at), base_poses(robot.X_WR, at), deviation)


def base_poses(X_WR: FloatArray, at: FloatArray) -> FloatArray:
    """Base poses (m, 4, 4) at fractional rows `at`: positions linear, turning at a constant rate."""
    poses = np.tile(np.eye(4), (len(at), 1, 1))
    poses[:, :3, 3] = _linear(X_WR[:, :3, 3], at)
    still = len(X_WR) < 2 or np.array_equal(X_WR[1:, :3, :3], X_WR[:-1, :3, :3])
    turning = None if still else Slerp(np.arange(len(X_WR)), Rotation.from_matrix(X_WR[:, :3, :3]))
    poses[:, :3, :3] = X_WR[0, :3, :3] if turning is None else turning(at).as_matrix()
    return poses


def _fractional_rows(first: int, parts: IntArray) -> FloatArray:
    """Fractional rows k + share, from row `first` on, with interval k divided into equal parts."""
    interval = np.repeat(np.arange(len(parts)), parts)
    number = np.arange(len(interval)) - np.repeat(np.cumsum(parts) - parts, parts)
    return first + np.append(interval + number / parts[interval], float(len(parts)))


def _linear(rows: FloatArray, at: FloatArray) -> FloatArray:
    row, share = _split(at, len(rows))
    after = rows[np.minimum(row + 1, len(rows) - 1)]
    return rows[row] + share[:, None] * (after - rows[row])


def _stamps(t_s: FloatArray, at: FloatArray) -> FloatArray:
    return _linear(t_s[:, None], at)[:, 0]


def _split(at: FloatArray, rows: int) -> tuple[IntArray, FloatArray]:
    row = np.minimum(at.astype(np.int64), max(rows - 2, 0))
    return row, at - row


def _hermite_deviation(robot: Robot, t_s: FloatArray) -> FloatArray:
    a, b = _rate_mismatch(robot, t_s)
    return 4.0 / 27.0 * (np.abs(a) + np.abs(b))


def _rate_mismatch(robot: Robot, t_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """a = h v0 - dq and b = h v1 - dq (n-1, j); zeros where rates are not recorded or no time passed."""
    dq, h = np.diff(robot.q, axis=0), np.diff(t_s)[:, None]
    if robot.qd is None:
        return np.zeros_like(dq), np.zeros_like(dq)
    return np.where(h > 0.0, h * robot.qd[:-1] - dq, 0.0), np.where(h > 0.0, h * robot.qd[1:] - dq, 0.0)


class _Hermite:
    """The cubic through recorded positions and rates."""

    def __init__(self, robot: Robot, t_s: FloatArray) -> None:
        self._q, (self._a, self._b) = robot.q, _rate_mismatch(robot, t_s)

    def q(self, at: FloatArray) -> FloatArray:
        """(m, j) positions at fractional rows."""
        row, share = _split(at, len(self._q))
        s = share[:, None]
        return _linear(self._q, at) + s * (1.0 - s) ** 2 * self._a[row] - s**2 * (1.0 - s) * self._b[row]

    def deviation(self, at: FloatArray) -> FloatArray:
        """(m-1, j) largest distance from the chord between neighbours of `at`, none of which spans a row."""
        row, start = _split(at[:-1], len(self._q))
        part = np.diff(at)
        ends = [np.abs(self._second_derivative(row, s)) for s in (start, start + part)]
        return part[:, None] ** 2 / 8.0 * np.maximum(*ends)

    def _second_derivative(self, row: IntArray, share: FloatArray) -> FloatArray:
        s = share[:, None]
        return (6.0 * s - 4.0) * self._a[row] - (2.0 - 6.0 * s) * self._b[row]
