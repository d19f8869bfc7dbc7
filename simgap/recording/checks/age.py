"""Check of the age of recorded velocities (s): differences and filters lag behind the stamp."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import Location, finding
from simgap.recording.checks.check import Checked, Setting
from simgap.recording.checks.frames import RIGHT_MISMATCH
from simgap.recording.checks.rates import Slopes, fast_rows, linear_slopes, mismatch, turning_slopes
from simgap.recording.checks.stack import stacked
from simgap.recording.recording import Trial

_CLEARER = 0.8  # A lag must explain a fifth of the mismatch to be believed.


def check_velocity_age(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Reports velocities that equal the motion half a frame or more earlier; nothing is changed."""
    findings = []
    for column, slopes, recorded in _pairs(setting, trials):
        candidates = {
            0.0: slopes.central,
            0.5: slopes.before,
            1.0: _one_row_later(slopes.central),
            1.5: _one_row_later(slopes.before),
        }
        rows = fast_rows(slopes.central, recorded)
        for implied in candidates.values():
            rows = rows & np.isfinite(implied).all(axis=1)
        off = {lag: mismatch(recorded, implied, rows) for lag, implied in candidates.items()}
        lag = min(off, key=lambda k: off[k])
        if lag > 0.0 and off[lag] < _CLEARER * off[0.0] and off[lag] < RIGHT_MISMATCH:
            text = f"'{column}' is the velocity of {lag:g} frames before its stamp"
            text += f" (mismatch {off[0.0]:.2g}, then {off[lag]:.2g})"
            where = Location(file="measurement.yaml")
            findings.append(finding("gap/velocity-age", text, where=where, value=lag, bound=0.0, unit="frames"))
    return Checked(trials, tuple(findings))


def _pairs(setting: Setting, trials: Sequence[Trial]) -> Iterator[tuple[str, Slopes, FloatArray]]:
    declared = setting.spec.columns
    if {"v", "p"} <= set(declared):
        yield "v", linear_slopes(trials, lambda t: t.p), stacked(trials, lambda t: t.v_W)
    if {"w_body", "w_world"} & set(declared) and {"q_wxyz", "q_xyzw"} & set(declared):
        yield "w", turning_slopes(trials, lambda t: t.quat_wxyz), stacked(trials, lambda t: t.w_B)
    for k, joint in enumerate(setting.joints):
        if f"qd_{joint.name}" in declared:
            yield (
                f"qd_{joint.name}",
                linear_slopes(trials, lambda t, k=k: t.q[:, [k]]),
                stacked(trials, lambda t, k=k: t.qd[:, [k]]),
            )


def _one_row_later(slopes: FloatArray) -> FloatArray:
    """Each row gets the slope of the row before; rows at the start of a trial have none there either."""
    return np.concatenate([np.full((1, slopes.shape[1]), np.nan), slopes[:-1]])
