"""Check of units and axes by the acceleration of tossed bodies in free fall."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import Location, finding
from simgap.recording.checks.check import Checked, Setting
from simgap.recording.checks.stack import owners, stacked, windows
from simgap.recording.recording import Trial

WINDOW = 9  # rows of one parabola
_AXES = "xyz"
_TILT_DEG = 20.0


def flight_acceleration(trials: Sequence[Trial]) -> FloatArray:
    """(3,) acceleration of the body's origin while nothing touches it, in units of p and t; zero if it never flies.

    Parabolas are fitted to windows of `WINDOW` rows; those whose curve exceeds their residual 30 times and whose
    acceleration is the same in the next half window count. Sliding gives such windows too, but slower ones: the median
    is over the fastest.
    """
    accelerations = _steady_windows([t for t in trials if t.has("p")])
    if not len(accelerations):
        return np.zeros(3)
    size = np.linalg.norm(accelerations, axis=1)
    return np.median(accelerations[size > 0.7 * np.quantile(size, 0.95)], axis=0)


def check_gravity_axis(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Reports a body that falls along another axis than gravity is declared."""
    if setting.spec.kind != "free_body":
        return Checked(trials)
    fall, gravity = flight_acceleration(trials), np.array(setting.spec.world.gravity_mps2)
    g, a = float(np.linalg.norm(gravity)), float(np.linalg.norm(fall))
    if g == 0.0 or not 0.7 * g < a < 1.4 * g or not _gains_speed(trials, fall):
        return Checked(trials)
    angle = float(np.degrees(np.arccos(np.clip(fall @ gravity / (a * g), -1.0, 1.0))))
    if angle < _TILT_DEG:
        return Checked(trials)
    axis = int(np.argmax(np.abs(fall)))
    text = (
        f"the body falls along {'-+'[int(fall[axis] > 0)]}{_AXES[axis]}, {angle:.0f} degrees off the declared gravity"
    )
    where = Location(file="measurement.yaml")
    return Checked(
        trials, (finding("gap/gravity-axis", text, where=where, value=angle, bound=_TILT_DEG, unit="degrees"),)
    )


def _gains_speed(trials: Sequence[Trial], fall: FloatArray) -> bool:
    """Whether bodies move along the acceleration for a part of the time, as falling ones do and braking ones do not."""
    steps = np.concatenate([np.diff(t.p, axis=0) for t in trials]) @ fall
    return float((steps > 0.0).mean()) > 0.2


def _steady_windows(trials: Sequence[Trial]) -> FloatArray:
    """(m, 3) accelerations of the windows that lie on one parabola."""
    if not trials:
        return np.zeros((0, 3))
    owner = owners(trials)
    runs = windows(stacked(trials, lambda t: t.p), owner, WINDOW)
    stamps = windows(stacked(trials, lambda t: t.t_s)[:, None], owner, WINDOW)[:, 0]
    steps = np.diff(stamps, axis=1)
    even = np.ptp(steps, axis=1) < 0.5 * steps.mean(axis=1)
    basis = np.vander(np.arange(WINDOW) - WINDOW // 2, 3)  # in steps
    curve = runs @ np.linalg.pinv(basis).T  # (m, 3, 3) coefficients, the quadratic first
    residual = np.sqrt(((runs - curve @ basis.T) ** 2).mean(axis=2).sum(axis=1))
    bend = 2.0 * curve[:, :, 0]
    size = np.linalg.norm(bend, axis=1)
    steady = np.zeros(len(bend), dtype=bool)
    half = WINDOW // 2
    steady[:-half] = np.linalg.norm(bend[half:] - bend[:-half], axis=1) < 0.2 * size[:-half]
    clear = size * (WINDOW - 1) ** 2 / 8.0 > 30.0 * residual
    return (bend / steps.mean(axis=1)[:, None] ** 2)[even & steady & clear]
