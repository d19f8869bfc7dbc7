"""Velocities and turning rates from poses, where a recording has none: slopes of local fits; SI.

A fit spans about the same share of the body's fall at every rate of rows, so that faster cameras give quieter rates,
not noisier ones.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray, IntArray

_HALF_SPAN = 0.065  # of the fall time, to either side: one row at 150 Hz for a body of 10 cm
_LEAST_FOR_PARABOLAS = 5  # rows; at either end of a trial, where fits are one-sided, fewer take a line


def rows_of_slopes(fall_s: float, step_s: float) -> int:
    """Rows of a fit, odd, at least three, for a body that falls its length in `fall_s`."""
    return 2 * max(1, round(_HALF_SPAN * fall_s / step_s)) + 1


def slope_noise_per_s(rows: int, step_s: float) -> float:
    """Noise of a slope over so many rows per noise of a reading."""
    return float(np.sqrt(12.0 / (rows * (rows**2 - 1.0)))) / step_s


def velocities(t_s: FloatArray, p: FloatArray, rows: int) -> FloatArray:
    """(n, k) slopes of positions (n, k)."""
    return _slopes(t_s, rows, lambda i, k: p[k] - p[i])


def body_rates(t_s: FloatArray, quat_wxyz: FloatArray, rows: int) -> FloatArray:
    """(n, 3) slopes of rotations (n, 4), body axes."""
    R = Rotation.from_quat(np.roll(quat_wxyz, -1, axis=1))
    return _slopes(t_s, rows, lambda i, k: (R[i].inv() * R[k]).as_rotvec())


def _slopes(t_s: FloatArray, rows: int, moved: Callable[[IntArray, IntArray], FloatArray]) -> FloatArray:
    """(n, k) at every row; `moved` is how far (m, k) each row of a second array is from that of a first."""
    n, half = len(t_s), rows // 2
    everyone = np.arange(n)
    out = np.zeros(moved(everyone, everyone).shape)
    inner = everyone[half : n - half]
    if len(inner):
        # A line through what was moved to either side, its middle free.
        at = np.array([t_s[inner + k] - t_s[inner] for k in range(-half, half + 1)])
        far = np.array([moved(inner, inner + k) for k in range(-half, half + 1)])
        at = at - at.mean(axis=0)
        out[inner] = np.einsum("kn,kni->ni", at, far) / (at**2).sum(axis=0)[:, None]
    for i in (*range(min(half, n)), *range(max(n - half, half), n)):
        first = min(max(i - half, 0), max(n - rows, 0))
        k = np.arange(first, min(first + rows, n)) if rows >= _LEAST_FOR_PARABOLAS else _side(i, n)
        order = 2 if len(k) >= _LEAST_FOR_PARABOLAS else 1
        if len(k) > 1:
            powers = np.stack([(t_s[k] - t_s[i]) ** o for o in range(order + 1)], axis=1)
            out[i] = np.linalg.lstsq(powers, moved(np.full(len(k), i), k), rcond=None)[0][1]
    return out


def _side(i: int, n: int) -> IntArray:
    """The row and the one beside it, at an end."""
    return np.array([k for k in ((0, 1) if i == 0 else (n - 2, n - 1)) if 0 <= k < n])
