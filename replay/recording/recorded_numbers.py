"""Recorded states by joint and body name (rad, m, s), and the checks of numbers that every format shares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding


@dataclass(frozen=True)
class RecordedStates:
    """t_s (n,) stamps; positions and rates (n,) by joint, poses X_WB (n, 4, 4) by free body or base."""

    t_s: FloatArray
    q: Mapping[str, FloatArray]
    qd: Mapping[str, FloatArray] = field(default_factory=dict)
    X_WB: Mapping[str, FloatArray] = field(default_factory=dict)


def invalid_recording(
    code: str, headline: str, file: str | None = None, line: int | None = None, **more: object
) -> InvalidInput:
    """The exception that ends reading with one finding."""
    diagnostic: Diagnostic = finding(code, headline, where=Location(file=file, line=line), **more)  # pyright: ignore[reportArgumentType]
    return InvalidInput(diagnostic)


def checked_stamps(t_s: FloatArray, file: str) -> FloatArray:
    """The stamps themselves. Raises InvalidInput where there are none, one is no number or time goes back."""
    t_s = np.asarray(t_s, dtype=np.float64)
    if len(t_s) == 0:
        raise invalid_recording("replay/invalid-value", "the recording has no sample", file)
    if not np.isfinite(t_s).all():
        raise invalid_recording(
            "replay/not-finite", f"time stamp of row {int(np.argmin(np.isfinite(t_s)))} is no number", file
        )
    back = np.flatnonzero(np.diff(t_s) < 0.0)
    if len(back):
        row = int(back[0]) + 1
        message = f"time goes back in row {row}, from {t_s[row - 1]:.6g} s to {t_s[row]:.6g} s"
        raise invalid_recording(
            "replay/time-decreases", message, file, value=float(t_s[row]), bound=float(t_s[row - 1]), unit="s"
        )
    return t_s


def checked_numbers(values: FloatArray, name: str, file: str) -> FloatArray:
    """The values as float64. Raises InvalidInput where one is no number."""
    values = np.asarray(values, dtype=np.float64)
    finite = np.isfinite(values).reshape(len(values), -1).all(axis=1)
    if not finite.all():
        raise invalid_recording("replay/not-finite", f"'{name}' of row {int(np.argmin(finite))} is no number", file)
    return values


def poses(position_m: FloatArray, quat_xyzw: FloatArray, name: str, file: str) -> FloatArray:
    """X (n, 4, 4) of positions (n, 3) and quaternions (n, 4), normalised. Raises InvalidInput for a zero quaternion."""
    position_m = checked_numbers(position_m, name, file)
    quat_xyzw = checked_numbers(quat_xyzw, name, file)
    lengths = np.linalg.norm(quat_xyzw, axis=1)
    if (lengths < 1e-6).any():
        raise invalid_recording(
            "replay/not-finite", f"'{name}' has no orientation in row {int(np.argmin(lengths))}", file
        )
    X = np.tile(np.eye(4), (len(position_m), 1, 1))
    X[:, :3, :3] = Rotation.from_quat(quat_xyzw).as_matrix()
    X[:, :3, 3] = position_m
    return X
