"""Sequence of the checks of time series, each after those that it relies on."""

from __future__ import annotations

from schemas.diagnostics import Diagnostic
from schemas.measurement import SensorNoise
from simgap.recording.checks.age import check_velocity_age
from simgap.recording.checks.angles import degrees_to_radians, unwrap_angles
from simgap.recording.checks.check import Check, Setting
from simgap.recording.checks.clock import check_rate, find_gaps, order_stamps, settle_jitter
from simgap.recording.checks.duplicates import drop_duplicates
from simgap.recording.checks.finite import drop_non_finite_rows
from simgap.recording.checks.flight import check_gravity_axis
from simgap.recording.checks.frames import check_linear_frame, check_orientation
from simgap.recording.checks.noise import estimate_noise
from simgap.recording.checks.outliers import drop_corrupted_rows
from simgap.recording.checks.quaternions import normalise_quaternions, unify_signs
from simgap.recording.checks.units import check_units
from simgap.recording.recording import Trial

CHECKS: tuple[Check, ...] = (
    drop_non_finite_rows,
    order_stamps,
    check_rate,
    normalise_quaternions,
    degrees_to_radians,
    unwrap_angles,
    drop_corrupted_rows,
    unify_signs,
    find_gaps,
    check_units,
    check_orientation,
    check_linear_frame,
    check_gravity_axis,
    settle_jitter,
    check_velocity_age,
)


def check_series(
    setting: Setting, trials: tuple[Trial, ...]
) -> tuple[tuple[Trial, ...], SensorNoise, tuple[Diagnostic, ...]]:
    """The trials after every check, the sensor noise, and all findings in order."""
    findings: list[Diagnostic] = []
    for check in CHECKS:
        trials, more = check(setting, trials)
        findings += more
        if not trials:
            return (), setting.spec.sensor_noise, tuple(findings)
    noise, more = estimate_noise(setting, trials)
    trials, copies = drop_duplicates(setting, trials, noise)
    return trials, noise, (*findings, *more, *copies)
