"""Removes rows without finite numbers where they are needed, and trials that become empty."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.arrays import BoolArray
from schemas.diagnostics import Severity
from simgap.recording.checks.check import Checked, Hit, Setting, over_trials
from simgap.recording.recording import COLUMNS, Trial

MIN_ROWS = 3
_INPUTS = ("effort", "command", "command_p", "command_quat_wxyz")
LARGEST_READING = 1e12  # in SI units; no reading is larger, and its square must not overflow
LARGEST_STAMP_S = 1e30  # beyond the nanoseconds of any epoch (1.8e18 in 2026); its square must not overflow
_SPARSE = 0.5  # An input that is mostly empty is logged slower than the rest, not broken.


def drop_non_finite_rows(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Without rows whose stamp, state or input is not finite, and without trials that have fewer than MIN_ROWS left.

    Velocities may be missing (a first difference has none) and are NaN then.
    """
    finite_trials: list[Trial] = []
    holes: list[Hit] = []
    empty: list[Hit] = []
    for recorded in trials:
        trial = _without_wild_numbers(recorded)
        keep = _whole_rows(setting, trial)
        sound = trial.rows(keep) if not keep.all() else trial
        gone = len(trial) - len(sound)
        if len(sound) < MIN_ROWS:
            empty.append(Hit(trial, len(sound), f"{len(sound)} of {len(trial)} rows hold a state"))
            continue
        if gone:
            text = f"{gone} of {len(trial)} rows dropped, the first is row {int(np.argmin(keep)) + 1}"
            holes.append(Hit(trial, gone, text))
        finite_trials.append(sound)
    findings = over_trials("gap/non-finite-rows", "rows without a number", holes, len(trials), unit="rows")
    findings += over_trials(
        "gap/empty-trial",
        f"fewer than {MIN_ROWS} rows",
        empty,
        len(trials),
        bound=MIN_ROWS,
        unit="rows",
        severity=Severity.WARNING if finite_trials else Severity.ERROR,
    )
    return Checked(tuple(finite_trials), findings)


def _whole_rows(setting: Setting, trial: Trial) -> BoolArray:
    declared = setting.spec.columns
    keep = np.abs(trial.t_s) < LARGEST_STAMP_S  # False for NaN
    if "p" in declared:
        keep &= np.isfinite(trial.p).all(axis=1)
    if "q_wxyz" in declared or "q_xyzw" in declared:
        keep &= np.isfinite(trial.quat_wxyz).all(axis=1)
    measured = np.array([f"q_{joint.name}" in declared for joint in setting.joints], dtype=bool)
    keep &= np.isfinite(trial.q[:, measured]).all(axis=1)
    for name in _INPUTS:
        finite = np.isfinite(getattr(trial, name))
        if len(trial):
            keep &= finite[:, finite.mean(axis=0) > _SPARSE].all(axis=1)
    return keep


def _without_wild_numbers(trial: Trial) -> Trial:
    """Infinite and absurd readings as missing ones."""
    wild = {name: np.abs(getattr(trial, name)) > LARGEST_READING for name in COLUMNS[1:]}
    return replace(trial, **{k: np.where(bad, np.nan, getattr(trial, k)) for k, bad in wild.items() if bad.any()})
