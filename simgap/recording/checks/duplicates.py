"""Check for one recording under two ids, which would leak from training to test and count twice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from geom.pose import to_xyzw
from schemas.arrays import FloatArray
from schemas.measurement import SensorNoise
from simgap.recording.checks.check import Checked, Hit, Setting, over_trials
from simgap.recording.recording import Trial

_KEY = 16  # rows of a fingerprint
_FINGERPRINT_DISTANCE = 0.02  # of the typical step: fingerprints closer than this are compared row by row
_OVERLAP = 0.6  # of the shorter trial
_COPY = 0.5  # of the sensor noise: two recordings of one motion differ by 1.4 times the noise, copies by rounding


def drop_duplicates(setting: Setting, trials: tuple[Trial, ...], noise: SensorNoise) -> Checked:
    """Each recording once: later copies go, also those that were turned about the vertical, shifted or cut.

    A fingerprint that such moves leave alone (steps of height and joints at the liveliest place) proposes pairs; all
    rows that overlap must then agree to a fraction of the sensor noise, so repeated experiments stay.
    """
    up = _up(setting)
    copy_of: dict[str, str] = {}
    hits: list[Hit] = []
    for first, later, shift in _proposed(trials, up):
        a, b = trials[first], trials[later]
        if a.id in copy_of or b.id in copy_of:
            continue
        yaw_deg = _turn_between(a, b, shift, noise, up)
        if yaw_deg is not None:
            copy_of[b.id] = a.id
            how = f"turned by {yaw_deg:.0f} degrees" if abs(yaw_deg) > 0.1 else "unchanged"
            hits.append(Hit(b, len(b), f"the recording of {a.id}, {how}"))
    originals = tuple(t for t in trials if t.id not in copy_of)
    text = "copies of another trial, left out"
    return Checked(originals, over_trials("gap/duplicate-trials", text, hits, len(trials), unit="rows"))


def _up(setting: Setting) -> FloatArray:
    gravity = np.array(setting.spec.world.gravity_mps2)
    size = np.linalg.norm(gravity)
    return -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])


def _proposed(trials: Sequence[Trial], up: FloatArray) -> Iterator[tuple[int, int, int]]:
    """(first, later, shift): row i + shift of the first trial may be row i of the later one."""
    columns = {k: np.column_stack([t.p @ up[:, None], t.q]) for k, t in enumerate(trials) if len(t) > 2 * _KEY}
    if len(columns) < 2:
        return
    known = np.all([np.isfinite(c).all(axis=0) for c in columns.values()], axis=0)
    steps = {k: np.diff(c[:, known], axis=0) for k, c in columns.items()}
    scale = np.concatenate(list(steps.values())).std(axis=0)
    if not known.any() or not (scale > 0.0).any():
        return
    keys = {k: sliding_window_view(s[:, scale > 0.0] / scale[scale > 0.0], _KEY, axis=0) for k, s in steps.items()}
    keys = {k: windows.reshape(len(windows), -1) for k, windows in keys.items()}
    owner = np.concatenate([np.full(len(w), k) for k, w in keys.items()])
    row = np.concatenate([np.arange(len(w)) for w in keys.values()])
    tree = KDTree(np.concatenate(list(keys.values())))
    seen: set[tuple[int, int]] = set()
    for k, windows in keys.items():
        spread = windows.var(axis=1)
        lively = int(np.argmax(spread))
        if spread[lively] == 0.0:
            continue
        for hit in tree.query_ball_point(windows[lively], _FINGERPRINT_DISTANCE * np.sqrt(windows.shape[1])):
            other, shift = int(owner[hit]), int(row[hit]) - lively
            pair = (min(k, other), max(k, other))
            if other != k and pair not in seen:
                seen.add(pair)
                yield (*pair, shift if other < k else -shift)


def _turn_between(a: Trial, b: Trial, shift: int, noise: SensorNoise, up: FloatArray) -> float | None:
    """Degrees of yaw that carry `a` onto `b` where they overlap, None if they are two recordings."""
    start_a, start_b = max(shift, 0), max(-shift, 0)
    n = min(len(a) - start_a, len(b) - start_b)
    if n < max(_OVERLAP * min(len(a), len(b)), _KEY):
        return None
    a, b = (t.rows(np.arange(start, start + n)) for t, start in ((a, start_a), (b, start_b)))
    for name in ("q", "effort", "command"):
        off = np.nan_to_num(getattr(a, name) - getattr(b, name))
        if np.abs(off).max(initial=0.0) > 0.2 * (noise.q or 0.0) + 1e-9:
            return None
    if not a.has("p"):
        return 0.0
    yaw = _yaw(a.p - a.p.mean(axis=0), b.p - b.p.mean(axis=0), up)
    turn = Rotation.from_rotvec(yaw * up)
    off_p = b.p - turn.apply(a.p)
    if (off_p - off_p.mean(axis=0)).std() > _COPY * (noise.p_m or 0.0) + 1e-7:
        return None
    if a.has("quat_wxyz"):
        turned = turn * Rotation.from_quat(to_xyzw(a.quat_wxyz))
        off_r = (turned.inv() * Rotation.from_quat(to_xyzw(b.quat_wxyz))).magnitude()
        if np.sqrt((off_r**2).mean()) > 2.0 * (noise.rotation_rad or 0.0) + 1e-3:
            return None
    return float(np.degrees(yaw))


def _yaw(a: FloatArray, b: FloatArray, up: FloatArray) -> float:
    """The angle about `up` that turns points `a` (n, 3) best onto `b`, in the plane (least squares)."""
    east = np.cross(up, [1.0, 0.0, 0.0] if abs(up[0]) < 0.9 else [0.0, 1.0, 0.0])
    east /= np.linalg.norm(east)
    plane = np.stack([east, np.cross(up, east)])
    (ax, ay), (bx, by) = plane @ a.T, plane @ b.T
    return float(np.arctan2((ax * by - ay * bx).sum(), (ax * bx + ay * by).sum()))
