"""scene_synthesizer on the boxes of the workload (`pip install scene-synthesizer`).

Its `place_object` draws poses on a labelled support and tests by FCL if meshes meet. Here boxes grown by half the
clearance a side; that they lie on the table, and `left_of`, is tested by its `valid_placement_fn`.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from math import atan2, cos, sin

import numpy as np
import scene_synthesizer as synth

from benchmarks.scenes.workload import CLEARANCE_M, TABLE_M
from schemas.arrays import FloatArray

Pairs = Sequence[tuple[int, int]]
THICK_M = 0.05


def rejection(
    sizes: FloatArray, pairs: Pairs, tries: int, limit_s: float, keep: int
) -> tuple[float, float, FloatArray]:
    """Scenes per CPU second, the share of attempts that succeed, and x, y, yaw (<= keep, n, 3)."""
    logging.getLogger("scene_synthesizer").setLevel(logging.ERROR)
    middle = ("center", "center")
    assets = [synth.BoxAsset(extents=[w, d, THICK_M], origin=(*middle, "bottom")) for w, d in sizes + CLEARANCE_M]
    scene = synth.Scene(seed=0)
    scene.add_object(synth.BoxAsset(extents=[*TABLE_M, THICK_M], origin=(*middle, "top")), "table")
    scene.label_support("top", erosion_distance=0.0, min_area=0.01)
    kept: list[FloatArray] = []
    done, begun, since = 0, 0, time.process_time()
    while time.process_time() - since < limit_s:
        poses = _attempt(scene, assets, sizes, pairs, tries)
        begun += 1
        if poses is not None:
            done += 1
            kept = [*kept, poses][-keep:]
    all_poses = np.array(kept).reshape(-1, len(sizes), 3)
    return done / (time.process_time() - since), done / begun, all_poses


def _attempt(
    scene: synth.Scene, assets: list[synth.BoxAsset], sizes: FloatArray, pairs: Pairs, tries: int
) -> FloatArray | None:
    for i in range(len(sizes)):
        if f"box{i}" in scene.graph.nodes:
            scene.remove_object(f"box{i}$")
    poses = np.zeros((len(sizes), 3))
    for i, asset in enumerate(assets):

        def valid(_asset: object, _support: object, X_WB: FloatArray, i: int = i) -> bool:
            return _allowed(i, X_WB, poses, sizes, pairs)

        if not scene.place_object(f"box{i}", asset, support_id="top", max_iter=tries, valid_placement_fn=valid):
            return None
        poses[i] = _planar(scene.get_transform(f"box{i}"))
    return poses


def _planar(X_WB: FloatArray) -> tuple[float, float, float]:
    return float(X_WB[0, 3]), float(X_WB[1, 3]), atan2(X_WB[1, 0], X_WB[0, 0])


def _reach(size: FloatArray, yaw: float) -> tuple[float, float]:
    c, s = abs(cos(yaw)) / 2, abs(sin(yaw)) / 2
    return c * size[0] + s * size[1], s * size[0] + c * size[1]


def _allowed(i: int, X_WB: FloatArray, poses: FloatArray, sizes: FloatArray, pairs: Pairs) -> bool:
    x, y, yaw = _planar(X_WB)
    reach_x, reach_y = _reach(sizes[i], yaw)
    if abs(x) + reach_x > TABLE_M[0] / 2 or abs(y) + reach_y > TABLE_M[1] / 2:
        return False
    for a, b in pairs:
        if i in (a, b) and max(a, b) == i:
            other = a + b - i
            step = (poses[other, 0] - x) * (1 if i == a else -1)
            if step < reach_x + _reach(sizes[other], poses[other, 2])[0]:
                return False
    return True
