"""Velocities implied by the positions of all trials at once, to compare recorded velocities with; SI."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from geom.pose import to_xyzw
from schemas.arrays import BoolArray, FloatArray
from simgap.recording.checks.stack import owners, stacked
from simgap.recording.recording import Trial

_FAST_SHARE = 0.5


class Slopes(NamedTuple):
    """Differences over the steps of all trials: `before` and `after` each row, NaN at ends and over gaps; (n, k)."""

    before: FloatArray
    after: FloatArray

    @property
    def central(self) -> FloatArray:
        """Mean of the two: second-order accurate in the middle of even steps."""
        return 0.5 * (self.before + self.after)


def linear_slopes(trials: Sequence[Trial], values: Callable[[Trial], FloatArray]) -> Slopes:
    """Slopes of columns (n, k), per second."""
    return _slopes(trials, np.diff(stacked(trials, values), axis=0))


def turning_slopes(trials: Sequence[Trial], quats: Callable[[Trial], FloatArray]) -> Slopes:
    """Angular velocity in body axes, rad/s, from orientations (n, 4) wxyz (second order: rotation vector per step)."""
    turn = Rotation.from_quat(to_xyzw(stacked(trials, quats)))
    return _slopes(trials, (turn[:-1].inv() * turn[1:]).as_rotvec())


def _slopes(trials: Sequence[Trial], change: FloatArray) -> Slopes:
    """`change` (N - 1, k) is from row to row; it means nothing between trials and over gaps."""
    owner, t_s = owners(trials), stacked(trials, lambda t: t.t_s)
    longest = 1.6 * np.array([np.median(np.diff(t.t_s)) for t in trials])[owner[1:]]
    steps = np.diff(t_s)
    sound = (owner[1:] == owner[:-1]) & (steps <= longest)
    slope = np.where(sound[:, None], change / np.where(sound, steps, 1.0)[:, None], np.nan)
    gap = np.full((1, slope.shape[1]), np.nan)
    return Slopes(np.concatenate([gap, slope]), np.concatenate([slope, gap]))


def fast_rows(implied: FloatArray, recorded: FloatArray) -> BoolArray:
    """(n,) the faster half of the rows in which both velocities are known: the informative ones."""
    speed = np.linalg.norm(implied, axis=1)
    known = np.isfinite(speed) & np.isfinite(recorded).all(axis=1)
    if not known.any():
        return known
    return known & (speed >= np.quantile(speed[known], 1.0 - _FAST_SHARE)) & (speed > 0.0)


def mismatch(recorded: FloatArray, implied: FloatArray, rows: BoolArray) -> float:
    """Median distance between two velocities over `rows`, as a fraction of the median implied speed; 0 is agreement."""
    if not rows.any():
        return 0.0
    off = np.linalg.norm(recorded[rows] - implied[rows], axis=1)
    return float(np.nanmedian(off) / np.nanmedian(np.linalg.norm(implied[rows], axis=1)))


def ratio(recorded: FloatArray, implied: FloatArray, rows: BoolArray) -> float:
    """Median recorded speed per implied speed over `rows`, whatever the axes; negative when a scalar runs backward."""
    if not rows.any():
        return 1.0
    sizes = np.linalg.norm(recorded[rows], axis=1) / np.linalg.norm(implied[rows], axis=1)
    sign = np.sign(np.median((recorded[rows] * implied[rows]).sum(axis=1))) if implied.shape[1] == 1 else 1.0
    return float(np.median(sizes) * (sign or 1.0))
