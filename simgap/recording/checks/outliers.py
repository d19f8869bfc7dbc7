"""Removes single rows that leave the path and come back, as corrupted lines and mirrored tags do."""

from __future__ import annotations

import numpy as np

from schemas.arrays import BoolArray, FloatArray
from simgap.recording.checks.check import Checked, Hit, Setting, over_trials
from simgap.recording.checks.quaternions import one_sign
from simgap.recording.recording import Trial

_SPIKE = 6.0  # times the steps around it; positions of real logs stay below 4
_SPIKE_RATE = 12.0  # for velocities and efforts, which real logs make rougher: they stay below 10
_MOST_SPIKE_SHARE = 0.02  # of the rows; more of them are no accident but the signal


def drop_corrupted_rows(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Without rows in which a column differs from both neighbours by more than any motion would."""
    hits: list[Hit] = []
    cleaned: list[Trial] = []
    for trial in trials:
        bad = np.zeros(len(trial), dtype=bool)
        smooth = (trial.p, one_sign(trial.quat_wxyz), *trial.q.T[:, :, None])
        rough = (trial.v_W, trial.w_B, *trial.qd.T[:, :, None], *trial.effort.T[:, :, None])
        for factor, columns in ((_SPIKE, smooth), (_SPIKE_RATE, rough)):
            for values in columns:
                if len(values) >= 7 and np.isfinite(values).all():
                    bad |= spikes(values, factor)
        if bad.any() and bad.sum() <= max(1.0, _MOST_SPIKE_SHARE * len(trial)):
            rows = ", ".join(str(r + 1) for r in np.flatnonzero(bad)[:5])
            hits.append(Hit(trial, float(bad.sum()), f"row {rows}"))
            trial = trial.rows(~bad)
        cleaned.append(trial)
    return Checked(tuple(cleaned), over_trials("gap/corrupted-rows", "rows off the path dropped", hits, len(trials)))


def spikes(values: FloatArray, factor: float = _SPIKE) -> BoolArray:
    """(n,) inner rows of (n, k) that differ from both neighbours in one direction, while the neighbours agree.

    The detour over the row must exceed `factor` times the largest step of its surroundings and of the trial's
    typical ones; an impact bends the path but does not bring it back.
    """
    steps = np.linalg.norm(np.diff(values, axis=0), axis=1)
    around = 0.5 * np.linalg.norm(values[2:] - values[:-2], axis=1)
    least = np.minimum(steps[:-1], steps[1:])
    out = np.zeros(len(values), dtype=bool)
    if not (least > factor * around).any():  # As in nearly every trial: spare the rest.
        return out
    calm = np.maximum(around, _neighbourhood(steps))
    count = float(steps[steps > 0.0].min())  # An encoder's single count is no jump.
    floor = max(0.25 * float(np.percentile(steps, 90)), count)
    out[1:-1] = least > factor * np.maximum(calm, floor)
    return out


def _neighbourhood(steps: FloatArray) -> FloatArray:
    """(n - 2,) median of the two steps before and the two after each inner row's own two."""
    padded = np.pad(steps, 2, mode="edge")
    n = len(steps) - 1
    return np.median(np.stack([padded[k : k + n] for k in (0, 1, 4, 5)]), axis=0)
