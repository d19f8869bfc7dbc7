"""Temporal refinement by probes, as in the paper: at a quarter, half and three quarters of each interval.

An interval is halved until the proxies' deviation at the probes, joint motion, root translation and root rotation are
within tolerance (X2Real technical report, "Motion proxies and temporal refinement"). Proves nothing about the times
between the probes; `replay.envelope.bounds` does, and is the default.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.pose import angle_between, quat_of
from replay.envelope.trajectory import Trajectory, at_fractional_rows
from replay.recording.episode import Robot
from replay.recording.kinematics import link_poses
from schemas.arrays import BoolArray, FloatArray

_PROBES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
_MOST_HALVINGS = 12  # halvings of an interval


@dataclass(frozen=True)
class Tolerances:
    """Tolerances: deviation of proxies (m), joint motion (rad or m), root translation (m) and root rotation (rad)."""

    proxy_m: float = 0.001
    joint: float = 0.1
    root_m: float = 0.02
    root_rad: float = 0.05


def refine_by_probes(robot: Robot, t_s: FloatArray, points: list[FloatArray], tolerances: Tolerances) -> Trajectory:
    """The linear trajectory, refined by probing points[l] (k, 3) of every link l."""
    first = np.arange(max(len(t_s) - 1, 0), dtype=float)
    last, places = first + 1.0, [first]
    for _ in range(_MOST_HALVINGS):
        wide = ~_within(robot, t_s, points, first, last, tolerances)
        if not wide.any():
            break
        middle = 0.5 * (first[wide] + last[wide])
        first, last = np.concatenate([first[wide], middle]), np.concatenate([middle, last[wide]])
        places.append(middle)
    return at_fractional_rows(robot, t_s, np.append(np.sort(np.concatenate(places)), float(len(t_s) - 1)))


def _within(
    robot: Robot, t_s: FloatArray, points: list[FloatArray], first: FloatArray, last: FloatArray, tolerances: Tolerances
) -> BoolArray:
    """(k,) whether intervals from `first` to `last` (fractional rows) are within tolerance."""
    at = first[:, None] + (last - first)[:, None] * _PROBES
    states = at_fractional_rows(robot, t_s, at.reshape(-1))
    probe_shape = (len(first), len(_PROBES))
    q, base = states.q.reshape(*probe_shape, -1), states.X_WR.reshape(*probe_shape, 4, 4)
    is_within = np.abs(q[:, -1] - q[:, 0]).max(axis=1, initial=0.0) <= tolerances.joint
    is_within &= np.linalg.norm(base[:, -1, :3, 3] - base[:, 0, :3, 3], axis=1) <= tolerances.root_m
    turns = [angle_between(quat_of(one[0, :3, :3]), quat_of(one[-1, :3, :3])) for one in base]
    is_within &= np.array(turns, dtype=float).reshape(-1) <= tolerances.root_rad
    poses = link_poses(robot, states.q, states.X_WR)
    for number, some in enumerate(points):
        X = poses[:, number]
        paths = (np.einsum("mij,kj->mki", X[:, :3, :3], some) + X[:, None, :3, 3]).reshape(*probe_shape, -1, 3)
        chord = paths[:, :1] + _PROBES[:, None, None] * (paths[:, -1:] - paths[:, :1])
        is_within &= np.linalg.norm(paths - chord, axis=3).max(axis=(1, 2), initial=0.0) <= tolerances.proxy_m
    return is_within
