"""Pushes as arrays on one grid: start and end in the plane, the tip's path, the force while it pushed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.arrays import FloatArray
from simgap.kinds.push.footprint import nearest
from simgap.kinds.push.sliding import plane_rotations
from simgap.recording.recording import Push

PATH_STEPS = 24  # of a tip's path: many more would follow the jitter of its readings
STEADY_FROM_SHARE = 0.5  # share of the path after which the force is averaged: contact is made, transients are over

_CONTACT = 0.3  # share of the steady force from which on the tip touches


@dataclass(frozen=True)
class Records:
    """before, after (n, 3) x, y, yaw; tips (n, PATH_STEPS, 2), even in time; force (n, 2) on the body, world axes,
    mean over the steady part, NaN where none was measured; ripple_N (n,) of that force within the push;
    force_all (n, 2) its mean over all the time of contact.
    """

    before: FloatArray
    after: FloatArray
    tips: FloatArray
    force: FloatArray
    ripple_N: FloatArray
    force_all: FloatArray

    @property
    def turned(self) -> FloatArray:
        """(n,) yaw gained."""
        return (self.after[:, 2] - self.before[:, 2] + np.pi) % (2.0 * np.pi) - np.pi


def record(pushes: Sequence[Push]) -> Records:
    """Pushes on the common grid."""
    rows = [_forces(p) for p in pushes]
    return Records(
        before=np.array([[*p.before_p[:2], yaw(p.before_quat_wxyz)] for p in pushes]),
        after=np.array([[*p.after_p[:2], yaw(p.after_quat_wxyz)] for p in pushes]),
        tips=np.stack([_path(p) for p in pushes]),
        force=np.stack([steady for steady, _, _ in rows]),
        ripple_N=np.array([ripple for _, ripple, _ in rows]),
        force_all=np.stack([whole for _, _, whole in rows]),
    )


def yaw(quat_wxyz: FloatArray) -> float:
    """Heading of the body's x axis in the plane."""
    R = Rotation.from_quat(np.roll(quat_wxyz, -1)).as_matrix()
    return float(np.arctan2(R[1, 0], R[0, 0]))


def upright(quat_wxyz: FloatArray) -> float:
    """Cosine between the body's z axis and up."""
    return float(Rotation.from_quat(np.roll(quat_wxyz, -1)).as_matrix()[2, 2])


def end_distance(outline: FloatArray, records: Records) -> FloatArray:
    """(n,) signed distance of the tip from the body's outline when the push was over."""
    away = records.tips[:, -1] - records.after[:, :2]
    return nearest(outline, np.einsum("nji,nj->ni", plane_rotations(records.after[:, 2]), away))[0]


def _path(push: Push) -> FloatArray:
    at = np.linspace(push.tip_t_s[0], push.tip_t_s[-1], PATH_STEPS)
    return np.stack([np.interp(at, push.tip_t_s, push.tip_p[:, k]) for k in (0, 1)], axis=1)


def _forces(push: Push) -> tuple[FloatArray, float, FloatArray]:
    """Mean steady force (2,), its ripple, and the mean force (2,) while there was contact."""
    first, last = push.tip_t_s[0], push.tip_t_s[-1]
    pushing = (push.force_t_s >= first) & (push.force_t_s <= last)
    steady = pushing & (push.force_t_s >= first + STEADY_FROM_SHARE * (last - first))
    if steady.sum() < 3:
        return np.full(2, np.nan), np.nan, np.full(2, np.nan)
    force = push.force[steady, :2]
    mean = force.mean(axis=0)
    strong = np.linalg.norm(push.force[:, :2], axis=1) > _CONTACT * np.linalg.norm(mean)
    return mean, float(force.std(axis=0).max()), push.force[pushing & strong, :2].mean(axis=0)
