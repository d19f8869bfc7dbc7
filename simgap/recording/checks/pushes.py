"""Checks of pushes: finite, ordered series, unit quaternions, a body that moved, a tip near the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray, IntArray
from schemas.diagnostics import Diagnostic, Label, Location, Severity, finding
from simgap.recording.checks.quaternions import LENGTH_TOLERANCE
from simgap.recording.recording import Push

_MOVED_M, _TURNED_RAD = 5e-4, 5e-3
_MOST_TIP_DISTANCE_M = 1.0


def check_pushes(pushes: Sequence[Push]) -> tuple[tuple[Push, ...], tuple[Diagnostic, ...]]:
    """The pushes that can be used, each with clean series, and the findings."""
    usable: list[Push] = []
    problems: dict[str, list[tuple[str, str]]] = {}
    for push in pushes:
        reason = _unusable(push)
        if reason:
            problems.setdefault(reason[0], []).append((push.id, reason[1]))
            continue
        clean, dropped = _clean(push)
        if dropped:
            problems.setdefault("gap/non-finite-rows", []).append((push.id, f"{dropped} rows dropped"))
        if _moved(clean) == 0.0:
            problems.setdefault("gap/push-inconsistent", []).append((push.id, "the body did not move"))
        elif (distance := _nearest(clean)) > _MOST_TIP_DISTANCE_M:
            text = f"the tip stays {distance:.3g} m away; unit or frame?"
            problems.setdefault("gap/push-inconsistent", []).append((push.id, text))
        usable.append(clean)
    copies = _copies(usable)
    for later, first in copies.items():
        problems.setdefault("gap/duplicate-trials", []).append((later, f"the push {first}"))
    return (
        tuple(p for p in usable if p.id not in copies),
        tuple(_finding(code, hits, len(pushes), bool(usable)) for code, hits in problems.items()),
    )


def _unusable(push: Push) -> tuple[str, str] | None:
    poses = np.concatenate([push.before_p, push.after_p])
    quats = np.stack([push.before_quat_wxyz, push.after_quat_wxyz])
    if not (np.isfinite(poses).all() and np.isfinite(quats).all()):
        return "gap/empty-trial", "a pose is missing"
    length = np.linalg.norm(quats, axis=1)
    if np.abs(length - 1.0).max() > LENGTH_TOLERANCE:
        return "gap/quaternion-not-unit", f"length {length.max():.3g}"
    if np.isfinite(push.tip_t_s).sum() < 2:
        return "gap/empty-trial", "the tip has no path"
    return None


def _clean(push: Push) -> tuple[Push, int]:
    """Unit quaternions, series sorted by their clock without rows that hold no number, and how many rows went."""
    tip = _order(push.tip_t_s, push.tip_p)
    force = _order(push.force_t_s, push.force)
    before, after = (q / np.linalg.norm(q) for q in (push.before_quat_wxyz, push.after_quat_wxyz))
    clean = replace(
        push,
        before_quat_wxyz=before,
        after_quat_wxyz=after if after @ before >= 0.0 else -after,
        tip_t_s=push.tip_t_s[tip],
        tip_p=push.tip_p[tip],
        tip_quat_wxyz=push.tip_quat_wxyz[tip],
        force_t_s=push.force_t_s[force],
        force=push.force[force],
    )
    return clean, len(push.tip_t_s) - len(tip) + len(push.force_t_s) - len(force)


def _order(t_s: FloatArray, values: FloatArray) -> IntArray:
    rows = np.flatnonzero(np.isfinite(t_s) & np.isfinite(values).all(axis=1))
    _, first = np.unique(t_s[rows], return_index=True)
    return rows[first]


def _moved(push: Push) -> float:
    """Distance of the body's move in m, 0 when neither that nor its turn is above the tracker's noise."""
    shift = float(np.linalg.norm(push.after_p - push.before_p))
    turn = 2.0 * np.arccos(min(1.0, abs(float(push.before_quat_wxyz @ push.after_quat_wxyz))))
    return max(shift, 1e-9) if shift > _MOVED_M or turn > _TURNED_RAD else 0.0


def _nearest(push: Push) -> float:
    return float(np.linalg.norm(push.tip_p[:, :2] - push.before_p[:2], axis=1).min())


def _copies(pushes: Sequence[Push]) -> dict[str, str]:
    """Later id to first id of pushes with the same poses and tip path."""
    seen: dict[bytes, str] = {}
    copies: dict[str, str] = {}
    for push in pushes:
        key = np.concatenate([push.before_p, push.after_p, push.tip_p.ravel()]).tobytes()
        if seen.setdefault(key, push.id) != push.id:
            copies[push.id] = seen[key]
    return copies


_TEXTS = {
    "gap/empty-trial": "pushes without poses or path, left out",
    "gap/quaternion-not-unit": "pushes without unit quaternions, left out",
    "gap/non-finite-rows": "rows without a number or stamped twice dropped",
    "gap/push-inconsistent": "pushes that cannot have been",
    "gap/duplicate-trials": "copies of another push, left out",
}


def _finding(code: str, hits: list[tuple[str, str]], total: int, any_left: bool) -> Diagnostic:
    labels = tuple(Label(where=Location(file=f"trajectories/{i}"), text=text) for i, text in hits[:5])
    return finding(
        code,
        f"{_TEXTS[code]}: {len(hits)} of {total}; {hits[0][0]}: {hits[0][1]}",
        where=labels[0].where,
        value=len(hits),
        unit="pushes",
        labels=labels,
        severity=None if any_left else Severity.ERROR,
    )
