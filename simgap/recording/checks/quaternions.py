"""Normalises orientations to unit quaternions with one sign over time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import Severity
from simgap.recording.checks.check import Checked, Hit, Setting, over_trials
from simgap.recording.recording import Trial

ROUNDING = 1e-4  # Five printed digits; not worth a finding.
LENGTH_TOLERANCE = 0.05  # A sloppy filter; farther off it is no quaternion.
DROPPED_SHARE = 0.1  # of a trial's rows: lost tracking, not a wrong column


def normalise_quaternions(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Rows within LENGTH_TOLERANCE of length 1 are scaled, a few others dropped; with more the trial is left out."""
    unit_trials: list[Trial] = []
    scaled: list[Hit] = []
    dropped: list[Hit] = []
    refused: list[Hit] = []
    for trial in trials:
        length = np.linalg.norm(trial.quat_wxyz, axis=1)
        off = np.abs(np.nan_to_num(length, nan=1.0) - 1.0)
        far = off > LENGTH_TOLERANCE
        if far.any():
            row = int(np.argmax(off))
            text = f"length {length[row]:.3g} in row {row + 1}, {int(far.sum())} of {len(trial)} rows off"
            if far.sum() > DROPPED_SHARE * len(trial):
                refused.append(Hit(trial, float(length[row]), text))
                continue
            dropped.append(Hit(trial, float(length[row]), text))
            trial, length, off = trial.rows(~far), length[~far], off[~far]
        if off.max(initial=0.0) > ROUNDING:
            scaled.append(Hit(trial, float(off.max()), f"length off by {off.max():.2g}"))
        unit_trials.append(replace(trial, quat_wxyz=trial.quat_wxyz / length[:, None]))
    code, total = "gap/quaternion-not-unit", len(trials)
    findings = over_trials(code, "quaternions scaled to length 1", scaled, total, bound=ROUNDING)
    findings += over_trials(code, "rows without a unit quaternion dropped", dropped, total, bound=LENGTH_TOLERANCE)
    severity = Severity.WARNING if unit_trials else Severity.ERROR
    text = "no unit quaternions; these trials are left out"
    return Checked(
        tuple(unit_trials),
        findings + over_trials(code, text, refused, total, bound=LENGTH_TOLERANCE, severity=severity),
    )


def unify_signs(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Successive quaternions on the same half of the sphere: q and -q are one orientation, but no one path."""
    unified: list[Trial] = []
    hits: list[Hit] = []
    for trial in trials:
        flips = int((np.einsum("ni,ni->n", trial.quat_wxyz[1:], trial.quat_wxyz[:-1]) < 0.0).sum())
        if flips:
            hits.append(Hit(trial, flips, f"{flips} sign changes"))
            trial = replace(trial, quat_wxyz=one_sign(trial.quat_wxyz))
        unified.append(trial)
    return Checked(tuple(unified), over_trials("gap/quaternion-sign", "quaternion signs unified", hits, len(trials)))


def one_sign(quat_wxyz: FloatArray) -> FloatArray:
    """The same orientations (n, 4) with no sign change from row to row; the first row keeps its sign."""
    flips = np.einsum("ni,ni->n", quat_wxyz[1:], quat_wxyz[:-1]) < 0.0
    return quat_wxyz * np.concatenate([[1.0], np.where(np.cumsum(flips) % 2, -1.0, 1.0)])[:, None]
