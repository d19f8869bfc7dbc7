"""Dense motion of a recording: poses of all moving bodies between its samples, linear and by cubic Hermite curves.

Hermite curves need recorded rates; both are used where rates are known.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from geom.pose import inverse
from replay.recording.episode import Episode, Robot, link_names
from replay.recording.kinematics import link_poses
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

SUB_TIMES = 16
INTERVALS = 256  # Intervals that are held in memory at once.


@dataclass(frozen=True)
class MovingBody:
    """One body over a stretch of a recording: X_WB (k, 4, 4) at the times of its `Stretch`."""

    name: str
    shapes: tuple[CollisionShape, ...]
    X_WB: FloatArray


@dataclass(frozen=True)
class Stretch:
    """Poses of everything that moves or could at times t_s (k,)."""

    t_s: FloatArray
    bodies: tuple[MovingBody, ...]


def dense_motion(episode: Episode, sub_times: int = SUB_TIMES) -> Iterator[Stretch]:
    """The recording in stretches, each sample and `sub_times` - 1 times after it in every interval, by both paths."""
    n = len(episode.t_s)
    for first in range(0, max(n - 1, 1), INTERVALS):
        last = min(first + INTERVALS, n - 1)
        for hermite in (False, True):
            if not hermite or any(robot.qd is not None for robot in episode.robots):
                yield _stretch(episode, slice(first, last + 1), sub_times, hermite)


def _stretch(episode: Episode, rows: slice, sub_times: int, hermite: bool) -> Stretch:
    t_s = episode.t_s[rows]
    share = np.arange(sub_times) / sub_times
    bodies = []
    for robot in episode.robots:
        q = positions(robot, rows, t_s, share, hermite)
        X_WL = link_poses(robot, q, between_poses(robot.X_WR[rows], share))
        names = link_names(episode, robot)
        bodies += [MovingBody(names[k], link.shapes, X_WL[:, k]) for k, link in enumerate(robot.links) if link.shapes]
    bodies += [MovingBody(o.name, o.shapes, between_poses(o.X_WB[rows], share)) for o in episode.objects if o.shapes]
    return Stretch(between(t_s[:, None], share)[:, 0], tuple(bodies))


def positions(robot: Robot, rows: slice, t_s: FloatArray, share: FloatArray, hermite: bool) -> FloatArray:
    """Joint positions (k, j) between samples; Hermite cubics if `hermite` and rates are recorded."""
    q = robot.q[rows]
    if not hermite or robot.qd is None:
        return between(q, share)
    return hermite_between(q, robot.qd[rows], t_s, share)


def between(values: FloatArray, share: FloatArray) -> FloatArray:
    """Rows (n, j) at shares (s,) of each interval, linear, and the last row: ((n - 1) s + 1, j)."""
    steps = np.diff(values, axis=0)
    dense = values[:-1, None] + share[None, :, None] * steps[:, None]
    return np.concatenate([dense.reshape(-1, values.shape[1]), values[-1:]])


def hermite_between(values: FloatArray, rates: FloatArray, t_s: FloatArray, share: FloatArray) -> FloatArray:
    """The same along cubics with the recorded rates (n, j) at both ends of an interval of t_s (n,)."""
    s = share[None, :, None]
    h = np.diff(t_s)[:, None, None]
    start, end = values[:-1, None], values[1:, None]
    out = (1.0 + 2.0 * s) * (1.0 - s) ** 2 * start + s**2 * (3.0 - 2.0 * s) * end
    out = out + h * (s * (1.0 - s) ** 2 * rates[:-1, None] + s**2 * (s - 1.0) * rates[1:, None])
    return np.concatenate([out.reshape(-1, values.shape[1]), values[-1:]])


def between_poses(X: FloatArray, share: FloatArray) -> FloatArray:
    """Poses (n, 4, 4) at shares (s,) of each interval: positions linear, rotations at constant rate (slerp)."""
    n = len(X)
    out = np.tile(np.eye(4), ((n - 1) * len(share) + 1, 1, 1))
    out[:, :3, 3] = between(X[:, :3, 3], share)
    if not np.ptp(X, axis=0).any():
        out[:, :3, :3] = X[0, :3, :3]
        return out
    turn = Rotation.from_matrix((inverse(X[:-1]) @ X[1:])[:, :3, :3]).as_rotvec()
    turns = Rotation.from_rotvec((share[None, :, None] * turn[:, None]).reshape(-1, 3)).as_matrix()
    out[:-1, :3, :3] = np.repeat(X[:-1, :3, :3], len(share), axis=0) @ turns
    out[-1, :3, :3] = X[-1, :3, :3]
    return out
