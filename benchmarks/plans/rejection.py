"""Rejection on the tabletop workload in numpy, many scenes at once, with exact oriented boxes and relations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from benchmarks.scenes.workload import CLEARANCE_M, TABLE_M


def filled(
    sizes: np.ndarray, pairs: Sequence[tuple[int, int]], order: Sequence[int], rng: Generator, n: int, tries: int
) -> np.ndarray:
    """(m, N, 3) x, y, yaw of those of n scenes that could be filled with boxes `sizes` (N, 2), one after the other.

    Each box has `tries` draws: a yaw, then a position on the table. One try draws whole scenes: what survives has the
    exact distribution. Of each pair the first box ends before the second begins, along x.
    """
    poses, alive = np.zeros((n, len(sizes), 3)), np.arange(n)
    for k, i in enumerate(order):
        before = list(order[:k])
        waiting, seated = alive, [alive[:0]]
        for _ in range(tries):
            if not len(waiting):
                break
            pose, half = _drawn(sizes[i], rng, len(waiting))
            placed = poses[np.ix_(waiting, np.asarray(before, dtype=np.intp))]
            good = _apart(pose, sizes[i], placed, sizes[before])
            for a, b in pairs:
                if i in (a, b) and (other := b if i == a else a) in before:
                    theirs = poses[waiting, other]
                    step = theirs[:, 0] - pose[:, 0]
                    good &= (step if i == a else -step) >= half[:, 0] + half_extents(sizes[other], theirs[:, 2])[:, 0]
            poses[waiting[good], i] = pose[good]
            seated.append(waiting[good])
            waiting = waiting[~good]
        alive = np.sort(np.concatenate(seated))
    return poses[alive]


def half_extents(size: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """(m, 2) half of the width and of the depth that boxes take at yaws (m,)."""
    c, s = np.abs(np.cos(yaw)), np.abs(np.sin(yaw))
    return 0.5 * np.stack([c * size[0] + s * size[1], s * size[0] + c * size[1]], axis=1)


def _drawn(size: np.ndarray, rng: Generator, m: int) -> tuple[np.ndarray, np.ndarray]:
    yaw = rng.uniform(-np.pi, np.pi, m)
    half = half_extents(size, yaw)
    return np.column_stack([rng.uniform(-1.0, 1.0, (m, 2)) * (np.array(TABLE_M) / 2 - half), yaw]), half


def _apart(pose: np.ndarray, size: np.ndarray, placed: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(m,) whether a box is the clearance away from all placed ones along an axis of either (separating axes)."""
    step, half, turn = placed[..., :2] - pose[:, None, :2], 0.5 * sizes, placed[..., 2]
    yaw = pose[:, 2]
    between = turn - yaw[:, None]
    c, s = np.abs(np.cos(between)), np.abs(np.sin(between))
    free = np.zeros(between.shape, dtype=bool)
    for axis in range(2):
        along = np.stack([np.cos(yaw + axis * np.pi / 2), np.sin(yaw + axis * np.pi / 2)], axis=-1)[:, None]
        others = c * half[:, axis] + s * half[:, 1 - axis]
        free |= np.abs((step * along).sum(axis=-1)) - others - 0.5 * size[axis] >= CLEARANCE_M
        theirs = np.stack([np.cos(turn + axis * np.pi / 2), np.sin(turn + axis * np.pi / 2)], axis=-1)
        own = 0.5 * (c * size[axis] + s * size[1 - axis])
        free |= np.abs((step * theirs).sum(axis=-1)) - own - half[:, axis] >= CLEARANCE_M
    return np.asarray(free.all(axis=1))
