"""Baseline samplers of other tools, on the boxes of the workload, timed in the same process as the solver.

Each takes sizes (n, 2), `left_of` pairs, a random generator and a CPU limit, and returns poses (n, 3) of x, y, yaw, or
None when it gave up. Rules as published: robosuite's UniformRandomSampler (bounding circles, 5000 tries an object), the
same with oriented boxes (robocasa), and shelf packing with random swaps. Relations are checked object by object.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from math import hypot, pi

import numpy as np
from numpy.random import Generator

from benchmarks.scenes.workload import CLEARANCE_M, TABLE_M
from schemas.arrays import FloatArray

Pairs = Sequence[tuple[int, int]]
TRIES = 5000


def circles(sizes: FloatArray, pairs: Pairs, rng: Generator, limit_s: float) -> FloatArray | None:
    """robosuite's rule: bounding circles must not meet."""
    radius = np.hypot(*(sizes + CLEARANCE_M).T) / 2

    def free(i: int, x: float, y: float, yaw: float, poses: FloatArray) -> bool:
        return all(hypot(x - poses[j, 0], y - poses[j, 1]) > radius[i] + radius[j] for j in range(i))

    return _rejection(free, sizes, pairs, rng, limit_s)


def oriented_boxes(sizes: FloatArray, pairs: Pairs, rng: Generator, limit_s: float) -> FloatArray | None:
    """The same loop with an exact test of oriented boxes grown by half the clearance, all tests at once in numpy."""
    half = (sizes + CLEARANCE_M) / 2

    def free(i: int, x: float, y: float, yaw: float, poses: FloatArray) -> bool:
        return not _boxes_meet(x, y, yaw, half[i], poses[:i], half[:i])

    return _rejection(free, sizes, pairs, rng, limit_s)


def _rejection(
    free: Callable[[int, float, float, float, FloatArray], bool],
    sizes: FloatArray,
    pairs: Pairs,
    rng: Generator,
    limit_s: float,
) -> FloatArray | None:
    # Boxes one after another at random poses, TRIES each, all anew when one finds no place; `free` judges (i, pose).
    end = time.process_time() + limit_s
    while time.process_time() < end:
        poses = np.zeros((len(sizes), 3))
        for i in range(len(sizes)):
            for _ in range(TRIES):
                x, y, yaw = _draw(sizes[i], rng)
                if free(i, x, y, yaw, poses) and _related(i, (x, y, yaw), poses, sizes, pairs):
                    poses[i] = x, y, yaw
                    break
                if time.process_time() > end:
                    return None
            else:
                break
        else:
            return poses
    return None


def shelves(sizes: FloatArray, pairs: Pairs, rng: Generator, limit_s: float) -> FloatArray | None:
    """Next-fit shelves from a noisy order of depths, then swaps in the order that do not raise the broken relations."""
    end = time.process_time() + limit_s
    grown = np.sort(sizes + CLEARANCE_M, axis=1)[:, ::-1].tolist()
    yaw = np.where(sizes[:, 0] >= sizes[:, 1], 0.0, pi / 2)
    n = len(sizes)
    while time.process_time() < end:
        order = np.argsort([-depth * noise for (_, depth), noise in zip(grown, rng.uniform(0.85, 1.0, n), strict=True)])
        order = order.tolist()
        cost, places = _rows(order, grown, pairs)
        for _ in range(4000):
            if cost <= 1e-12 and places is not None:
                return np.column_stack([np.array(places), yaw])
            i = int(rng.integers(n))
            j = min(max(i + int(rng.integers(-12, 13)), 0), n - 1)
            order[i], order[j] = order[j], order[i]
            other, moved = _rows(order, grown, pairs)
            if other <= cost:
                cost, places = other, moved
            else:
                order[i], order[j] = order[j], order[i]
            if time.process_time() > end:
                return None
    return None


def _rows(order: list[int], grown: list[list[float]], pairs: Pairs) -> tuple[float, list[tuple[float, float]] | None]:
    width, depth = TABLE_M[0] + CLEARANCE_M, TABLE_M[1] + CLEARANCE_M
    x = y = row = 0.0
    places = [(0.0, 0.0)] * len(order)
    for i in order:
        w, d = grown[i]
        if x + w > width:
            x, y, row = 0.0, y + row, 0.0
        if y + d > depth:
            return 1e9, None
        places[i] = (x + w / 2 - width / 2, y + d / 2 - depth / 2)
        x, row = x + w, max(row, d)
    over = (places[a][0] + grown[a][0] / 2 - places[b][0] + grown[b][0] / 2 - CLEARANCE_M for a, b in pairs)
    return sum(max(0.0, value) for value in over), places


def _draw(size: FloatArray, rng: Generator) -> tuple[float, float, float]:
    yaw = rng.uniform(0.0, 2 * pi)
    hx, hy = _half_extents(size, yaw)
    x, y = rng.uniform(hx - TABLE_M[0] / 2, TABLE_M[0] / 2 - hx), rng.uniform(hy - TABLE_M[1] / 2, TABLE_M[1] / 2 - hy)
    return x, y, yaw


def _half_extents(size: FloatArray, yaw: float) -> tuple[float, float]:
    c, s = abs(np.cos(yaw)), abs(np.sin(yaw))
    return float(c * size[0] + s * size[1]) / 2, float(s * size[0] + c * size[1]) / 2


def _related(i: int, pose: tuple[float, float, float], poses: FloatArray, sizes: FloatArray, pairs: Pairs) -> bool:
    for a, b in pairs:
        if i not in (a, b) or max(a, b) > i:
            continue
        left, right = (pose if k == i else poses[k] for k in (a, b))
        if left[0] + _half_extents(sizes[a], left[2])[0] > right[0] - _half_extents(sizes[b], right[2])[0]:
            return False
    return True


def _boxes_meet(x: float, y: float, yaw: float, half: FloatArray, poses: FloatArray, halves: FloatArray) -> bool:
    # Separating axes of one oriented box against many (Gottschalk et al. 1996).
    if not len(poses):
        return False
    dx, dy = poses[:, 0] - x, poses[:, 1] - y
    ca, sa, cb, sb = np.cos(yaw), np.sin(yaw), np.cos(poses[:, 2]), np.sin(poses[:, 2])
    c, s = np.abs(ca * cb + sa * sb), np.abs(ca * sb - sa * cb)
    meets = np.abs(dx * ca + dy * sa) < half[0] + halves[:, 0] * c + halves[:, 1] * s
    meets &= np.abs(-dx * sa + dy * ca) < half[1] + halves[:, 0] * s + halves[:, 1] * c
    meets &= np.abs(dx * cb + dy * sb) < halves[:, 0] + half[0] * c + half[1] * s
    meets &= np.abs(-dx * sb + dy * cb) < halves[:, 1] + half[0] * s + half[1] * c
    return bool(meets.any())
