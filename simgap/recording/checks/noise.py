"""Estimate of sensor noise where none is declared: residual of short windows from a smooth curve, SI."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from geom.pose import to_xyzw
from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.measurement import SensorNoise
from simgap.recording.checks.check import Setting
from simgap.recording.checks.stack import owners, stacked, windows
from simgap.recording.recording import Trial

WINDOW, POLYNOMIAL_DEGREE = 9, 2
_MEDIAN_OF_CHI = 0.944  # sqrt(median(chi2_6) / 6): the median window of Gaussian noise is this much too quiet
METHOD = f"median residual of parabolas over {WINDOW} rows, at least one count of the sensor over sqrt(12)"


def estimate_noise(setting: Setting, trials: Sequence[Trial]) -> tuple[SensorNoise, tuple[Diagnostic, ...]]:
    """The declared noise completed by estimates for every measured channel, and a note that says which.

    Impacts fill only a minority of windows, so the median does not see them; a recording that was filtered looks
    quieter than its sensor.
    """
    declared = setting.spec.sensor_noise
    channels: dict[str, Callable[[Trial], FloatArray]] = {
        "p_m": lambda t: t.p,
        "rotation_rad": lambda t: t.quat_wxyz,
        "v_mps": lambda t: t.v_W,
        "w_radps": lambda t: t.w_B,
        "q": lambda t: t.q,
        "qd": lambda t: t.qd,
    }
    owner = owners(trials)
    estimates: dict[str, float] = {}
    for name, column in channels.items():
        if getattr(declared, name) is not None:
            continue
        values = stacked(trials, column)
        sigma = channel_noise(_turned(values) if name == "rotation_rad" else values, owner)
        if sigma is not None:
            estimates[name] = sigma
    if not estimates:
        return declared, ()
    text = "sensor noise estimated: " + ", ".join(f"{k} {v:.2g}" for k, v in estimates.items()) + f" ({METHOD})"
    return declared.model_copy(update=estimates), (
        finding("gap/noise-estimated", text, where=Location(file="measurement.yaml")),
    )


def channel_noise(values: FloatArray, owner: IntArray) -> float | None:
    """One standard deviation per component of stacked series (N, k), None where no window holds finite numbers.

    At least a millionth of the channel's spread, so that noise-free data do not divide by zero.
    """
    if not values.size or not np.isfinite(values).any():
        return None
    runs = windows(values, owner, WINDOW)
    rms = np.sqrt(((runs @ _residual_of_parabola()) ** 2).sum(axis=-1) / (WINDOW - POLYNOMIAL_DEGREE - 1))
    rms = rms[(rms > 0.0) & (runs[..., 0] != runs[..., -1])]  # At rest a coarse sensor shows no noise at all.
    if not len(rms):
        return None
    sigma = float(np.median(rms)) / _MEDIAN_OF_CHI
    count = sensor_count(np.diff(values, axis=0)[owner[1:] == owner[:-1]])
    return float(max(sigma, count / np.sqrt(12.0), 1e-6 * np.nanstd(values), 1e-12))


def sensor_count(steps: FloatArray) -> float:
    """The sensor's smallest step when all steps are whole multiples of it (an encoder), else 0."""
    sizes = np.abs(steps[np.isfinite(steps) & (steps != 0.0)])
    if len(sizes) < 2 * WINDOW:
        return 0.0
    count = float(np.quantile(sizes, 0.02))
    multiples = sizes / count
    near = np.abs(multiples - np.rint(multiples)) < 0.05
    return count if near.mean() > 0.95 and multiples.max() < 1e4 else 0.0


def _residual_of_parabola() -> FloatArray:
    """(WINDOW, WINDOW) projection onto what a parabola cannot follow."""
    basis = np.vander(np.linspace(-1.0, 1.0, WINDOW), POLYNOMIAL_DEGREE + 1)
    return np.eye(WINDOW) - basis @ np.linalg.pinv(basis)


def _turned(quat_wxyz: FloatArray) -> FloatArray:
    """(N, 3) rotation vectors summed up row by row: smooth where the motion is, and noisy as the orientation is."""
    if not np.isfinite(quat_wxyz).all():
        return np.full((len(quat_wxyz), 3), np.nan)
    turn = Rotation.from_quat(to_xyzw(quat_wxyz))
    return np.concatenate([np.zeros((1, 3)), np.cumsum((turn[:-1].inv() * turn[1:]).as_rotvec(), axis=0)])
