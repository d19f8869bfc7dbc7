"""Oriented-box rejection compiled by numba: what a few dozen lines draw without a plan (`pip install numba`).

robocasa's rule: boxes in the order given, each at a random yaw and place on the table, `tries` times at most, all anew
when one finds no room. Two boxes are apart when the clearance lies between them along an axis of either (Gottschalk et
al. 1996), which is looked at only where their circles meet. `left_of` is checked with the boxes already placed.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from math import cos, hypot, pi, sin

import numpy as np
from numba import njit
from numpy.random import Generator

from benchmarks.scenes.workload import CLEARANCE_M, TABLE_M
from schemas.arrays import FloatArray, IntArray

LOT = 64  # attempts between two looks at the clock
RUNS = 5


def rejection(
    sizes: FloatArray, pairs: Sequence[tuple[int, int]], tries: int, limit_s: float, keep: int
) -> tuple[float, float, FloatArray]:
    """Scenes per CPU second, the best of five runs; the share of attempts that succeed; x, y, yaw (<= keep, n, 3)."""
    rng = np.random.default_rng(0)
    side = np.zeros((len(sizes), len(sizes)), dtype=np.int64)  # 1 where the row is left of the column, -1 right
    for a, b in pairs:
        side[a, b], side[b, a] = 1, -1
    poses = np.zeros((keep, len(sizes), 3))
    _draw(rng, 1, poses, 0, sizes / 2, side, tries)  # compiles
    best, done, begun = 0.0, 0, 0
    for _ in range(RUNS):
        since, before = time.process_time(), done
        while time.process_time() - since < limit_s / RUNS:
            done += _draw(rng, LOT, poses, done, sizes / 2, side, tries)
            begun += LOT
        best = max(best, (done - before) / (time.process_time() - since))
    return best, done / begun, poses[:done]


@njit
def _draw(
    rng: Generator, attempts: int, poses: FloatArray, at: int, half: FloatArray, side: IntArray, tries: int
) -> int:
    """How many attempts succeed; their poses go to `poses`, number `at` first, round and round."""
    pose = np.zeros((len(half), 7))  # x, y, yaw, its cosine and sine, half the extent along x, radius
    done = 0
    for _ in range(attempts):
        for i in range(len(half)):
            if not _seated(rng, i, pose, half, side, tries):
                break
        else:
            poses[(at + done) % len(poses)] = pose[:, :3]
            done += 1
    return done


@njit
def _seated(rng: Generator, i: int, pose: FloatArray, half: FloatArray, side: IntArray, tries: int) -> bool:
    radius = hypot(half[i, 0], half[i, 1])
    for _ in range(tries):
        yaw = rng.uniform(-pi, pi)
        c, s = cos(yaw), sin(yaw)
        reach_x = abs(c) * half[i, 0] + abs(s) * half[i, 1]
        reach_y = abs(s) * half[i, 0] + abs(c) * half[i, 1]
        x = rng.uniform(-1.0, 1.0) * (TABLE_M[0] / 2 - reach_x)
        y = rng.uniform(-1.0, 1.0) * (TABLE_M[1] / 2 - reach_y)
        good = True
        for j in range(i):
            dx, dy, cj, sj = pose[j, 0] - x, pose[j, 1] - y, pose[j, 3], pose[j, 4]
            if side[i, j] != 0 and side[i, j] * dx < reach_x + pose[j, 5]:
                good = False
                break
            if dx * dx + dy * dy >= (radius + pose[j, 6] + CLEARANCE_M) ** 2:
                continue
            cc, ss = abs(c * cj + s * sj), abs(c * sj - s * cj)
            if (
                abs(dx * c + dy * s) < half[i, 0] + half[j, 0] * cc + half[j, 1] * ss + CLEARANCE_M
                and abs(dy * c - dx * s) < half[i, 1] + half[j, 0] * ss + half[j, 1] * cc + CLEARANCE_M
                and abs(dx * cj + dy * sj) < half[j, 0] + half[i, 0] * cc + half[i, 1] * ss + CLEARANCE_M
                and abs(dy * cj - dx * sj) < half[j, 1] + half[i, 0] * ss + half[i, 1] * cc + CLEARANCE_M
            ):
                good = False
                break
        if good:
            pose[i] = x, y, yaw, c, s, reach_x, radius
            return True
    return False
