"""Joint rates and accelerations from readings: local cubics (Savitzky and Golay, Anal. Chem. 36, 1964)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

from schemas.arrays import FloatArray

_SPAN_S = 0.06  # of the local cubic; at least 7 rows, at most 61
ORDER = 3


@dataclass(frozen=True)
class Smooth:
    """q, qd, qdd (n, j) of the local cubics over `rows` readings, the readings' noise (j,), that of `qd` (j,).

    `kept` is the share of a reading's noise (rms) that its smoothed value keeps.
    """

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    q_noise: FloatArray
    qd_noise: FloatArray
    rows: int
    noise_gain: float


def smooth(t_s: FloatArray, q: FloatArray) -> Smooth:
    """Local cubics through readings (n, j) at stamps (n,), resampled to even steps first when the stamps are uneven.

    The noise is what the cubics leave, corrected for the freedom they take. Raises ValueError below 7 rows.
    """
    if len(t_s) < 7:
        raise ValueError(f"{len(t_s)} rows are too few for derivatives; at least 7 are needed")
    step = float(np.median(np.diff(t_s)))
    even = np.arange(t_s[0], t_s[-1] + 0.5 * step, step)
    readings = np.stack([np.interp(even, t_s, column) for column in q.T], axis=1)
    rows = int(np.clip(round(_SPAN_S / step), 7, 61)) | 1
    rows = min(rows, len(even) if len(even) % 2 else len(even) - 1)
    fitted, rate, change = (
        np.asarray(savgol_filter(readings, rows, ORDER, deriv=d, delta=step, axis=0, mode="interp")) for d in range(3)
    )
    centre = np.asarray(savgol_coeffs(rows, ORDER))[rows // 2]
    spread = 1.4826 * np.median(np.abs(readings - fitted), axis=0)
    q_noise = np.maximum(spread / np.sqrt(max(1.0 - centre, 0.1)), 1e-12)
    qd_noise = q_noise * np.linalg.norm(np.asarray(savgol_coeffs(rows, ORDER, deriv=1, delta=step)))

    def back(values: FloatArray) -> FloatArray:
        return np.stack([np.interp(t_s, even, column) for column in values.T], axis=1)

    return Smooth(back(fitted), back(rate), back(change), q_noise, qd_noise, rows, float(np.sqrt(max(centre, 0.0))))
