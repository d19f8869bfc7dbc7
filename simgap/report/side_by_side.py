"""Measured and simulated motion of a trial side by side, from the residuals of full roll-outs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from sim.dynamics.mechanism import Windows
from simgap.kinds.mechanism.apply_model import Applied
from simgap.kinds.mechanism.logs import log_of
from simgap.kinds.mechanism.windows import cut, windows_of
from simgap.problem import Model, Problem
from simgap.recording.recording import Trial

_TWIST = 6  # channels of a pose: position and rotation vector
_POSE = ("px", "py", "pz", "qw", "qx", "qy", "qz")


@dataclass(frozen=True)
class SideBySide:
    """One trial: stamps (k,), column names, measured and simulated columns (k, m), errors (k, c) per channel.

    Joints in rad or m; bodies as position in m and quaternion wxyz, then their joints.
    """

    trial: str
    t_s: FloatArray
    columns: tuple[str, ...]
    measured: FloatArray
    simulated: FloatArray
    errors: FloatArray


def side_by_side(problem: Problem, trial: Trial, model: Model) -> SideBySide:
    """The full roll-out of `model` from the first row of `trial`."""
    errors = problem.residuals(model, [trial.id], "full_rollout")[0]
    motion = problem.joint_motion(trial.id)
    if motion is not None:
        return SideBySide(trial.id, motion.t_s, problem.channels(), motion.q, motion.q + errors, errors)
    since = problem.features([trial.id], "full_rollout")[0][:, -1]
    rows = np.clip(np.searchsorted(trial.t_s, trial.t_s[0] + since - 1e-9), 0, len(trial) - 1)
    joints = problem.channels()[_TWIST:]
    measured = np.concatenate([trial.p[rows], trial.quat_wxyz[rows], trial.q[rows, : len(joints)]], axis=1)
    turned = Rotation.from_rotvec(errors[:, 3:_TWIST]) * Rotation.from_quat(np.roll(trial.quat_wxyz[rows], -1, axis=1))
    turns = trial.q[rows, : len(joints)] + errors[:, _TWIST:]
    simulated = np.concatenate([trial.p[rows] + errors[:, :3], np.roll(turned.as_quat(), 1, axis=1), turns], axis=1)
    return SideBySide(trial.id, trial.t_s[rows], (*_POSE, *joints), measured, simulated, errors)


def joint_windows(trial: Trial, applied: Applied) -> Windows:
    """The whole trial of a mechanism as one window, as the roll-outs see it."""
    log = log_of(trial)
    return windows_of([(applied.recovered(log.series), cut(len(log.series.t_s), None, log.margin))], applied)


def read_positions(trial: Trial) -> FloatArray:
    """(k, j) joint positions as read, at the rows of `joint_windows`."""
    log = log_of(trial)
    return log.series.columns["reading"][cut(len(log.series.t_s), None, log.margin).rows[0]]


def largest_improvement(declared: list[SideBySide], extended: list[SideBySide], floor: FloatArray) -> tuple[int, int]:
    """Trial and channel where the extension removes most of the error; with none, where the error is greatest.

    Errors count by their logarithm over the noise, so that one roll-out that diverged does not hide the others.
    """
    floor = np.maximum(floor, 1e-12)

    def size(r: SideBySide) -> FloatArray:
        return np.nanmean(np.log1p((r.errors / floor) ** 2), axis=0)

    gains = np.array([size(a) - size(b) for a, b in zip(declared, extended, strict=True)])
    if not (gains > 0.0).any():
        gains = np.array([size(a) for a in declared])
    # A body's turning is harder to read than its path.
    readable = gains[:, :3] if declared[0].columns[0] == "px" else gains
    trial, channel = np.unravel_index(int(np.argmax(readable)), readable.shape)
    return int(trial), int(channel)
