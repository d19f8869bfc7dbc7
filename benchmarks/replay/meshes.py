"""The envelope of recordings that bring their collision meshes (`meshes_body_frame.npz`) beside those meshes.

    OMP_NUM_THREADS=1 python -m benchmarks.replay.meshes EPISODES

For each recording, from the vertices and triangles as they were recorded, not from what was read of them: how far any
hull vertex ever is outside the envelope without clearance, at 16 times in each interval by both paths; and by link the
volume of the envelope over that of the meshes' sweep, both with 1 cm of clearance, more than 0.4 m from the base.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import open3d as o3d
from scipy.spatial import ConvexHull

from benchmarks.replay.recordings import Reached, tightness
from geom.pose import apply
from replay.envelope.envelope import Envelope, Settings, swept_envelope
from replay.recording.episode import Episode
from replay.recording.formats.read import is_recording, read_episode
from replay.verification.dense import dense_motion
from schemas.arrays import BoolArray, FloatArray, IntArray

MESHES = "meshes_body_frame.npz"
SUB_TIMES, CLEARANCE_M, AT_ONCE = 16, 0.01, 32
Mesh = tuple[FloatArray, IntArray]  # vertices (v, 3) in the body's frame, triangles (f, 3)


def recorded_meshes(folder: Path) -> dict[str, list[Mesh]]:
    """Meshes by body."""
    meshes: dict[str, list[Mesh]] = {}
    with np.load(folder / MESHES) as stored:
        for key in stored.files:
            if key.endswith("|v"):
                meshes.setdefault(key.split("|")[0], []).append((stored[key], stored[key[:-1] + "f"]))
    return meshes


def first_rows(episode: Episode, count: int) -> Episode:
    """The same recording, ended after `count` rows."""
    robots = tuple(
        replace(one, q=one.q[:count], X_WR=one.X_WR[:count], qd=None if one.qd is None else one.qd[:count])
        for one in episode.robots
    )
    objects = tuple(replace(one, X_WB=one.X_WB[:count]) for one in episode.objects)
    return replace(episode, t_s=episode.t_s[:count], robots=robots, objects=objects, cameras=())


def farthest_outside(
    episode: Episode, envelope: Envelope, meshes: Mapping[str, list[Mesh]], vertices: int | None = None
) -> tuple[int, float]:
    """Number of tested points, and the largest distance (m) of one from the capsules of its body (negative: inside).

    Of each mesh's hull all vertices, or about so many of them.
    """
    asked, worst = 0, -np.inf
    corners = {name: np.concatenate([_hull(v, vertices) for v, _ in meshes.get(name, [])] or [np.zeros((0, 3))])
               for name in envelope.bodies}  # fmt: skip
    for stretch in dense_motion(episode, SUB_TIMES):
        for body in stretch.bodies:
            if body.name not in corners or not len(corners[body.name]):
                continue
            mine = envelope.body == envelope.bodies.index(body.name)
            for first in range(0, len(stretch.t_s), AT_ONCE):
                t_s = stretch.t_s[first : first + AT_ONCE]
                there = mine & (envelope.t_from_s <= t_s[-1] + 1e-9) & (envelope.t_to_s >= t_s[0] - 1e-9)
                places = np.concatenate([apply(X, corners[body.name]) for X in body.X_WB[first : first + AT_ONCE]])
                asked, worst = asked + len(places), max(worst, _outside(places, envelope, there))
    return asked, worst


def _hull(vertices: FloatArray, count: int | None) -> FloatArray:
    corners = vertices[ConvexHull(vertices).vertices]
    return corners if count is None else corners[:: max(1, len(corners) // count)]


def _outside(places: FloatArray, envelope: Envelope, capsules: BoolArray) -> float:
    a, radius = envelope.start_W[capsules], envelope.radius_m[capsules]
    along = envelope.end_W[capsules] - a
    squared = np.maximum((along**2).sum(axis=1), 1e-300)
    offset = places @ along.T - (a * along).sum(axis=1)  # (p - a) . along, for all pairs
    share = np.clip(offset / squared, 0.0, 1.0)
    apart = (places**2).sum(axis=1)[:, None] - 2.0 * places @ a.T + (a**2).sum(axis=1)
    distance = np.sqrt(np.maximum(apart - 2.0 * share * offset + share**2 * squared, 0.0))
    return float((distance - radius).min(axis=1).max())


def by_meshes(meshes: Mapping[str, list[Mesh]]) -> Reached:
    """What comes within the clearance of the recorded meshes, at every other pose."""

    def reached(name: str, points: FloatArray, X_WB: FloatArray) -> BoolArray | None:
        return _reached(points, X_WB[::2], meshes[name]) if name in meshes else None

    return reached


def _reached(points: FloatArray, X_WB: FloatArray, meshes: list[Mesh]) -> BoolArray:
    """Which points come within the clearance of the meshes at some pose."""
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    for vertices, triangles in meshes:
        scene.add_triangles(
            o3d.core.Tensor.from_numpy(vertices.astype(np.float32)),
            o3d.core.Tensor.from_numpy(triangles.astype(np.uint32)),
        )
    hit = np.zeros(len(points), dtype=bool)
    for X in X_WB:
        left = np.flatnonzero(~hit)
        if not len(left):
            break
        local = ((points[left] - X[:3, 3]) @ X[:3, :3]).astype(np.float32)
        hit[left[scene.compute_signed_distance(o3d.core.Tensor.from_numpy(local)).numpy() <= CLEARANCE_M]] = True
    return hit


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("episodes", type=Path)
    parser.add_argument("--vertices", type=int, default=150, help="about so many of each hull")
    given = parser.parse_args()
    for folder in sorted(given.episodes.iterdir()):
        if not ((folder / MESHES).is_file() and is_recording(folder)):
            continue
        started = time.process_time()
        episode, meshes = read_episode(folder), recorded_meshes(folder)
        asked, worst = farthest_outside(
            episode, swept_envelope(episode, Settings(clearance_m=0.0)), meshes, given.vertices
        )
        figures = {
            "episode": episode.name,
            "places": asked,
            "farthest_outside_mm": round(1e3 * worst, 4),
            "volume_ratio": tightness(
                episode, swept_envelope(episode, Settings(clearance_m=CLEARANCE_M)), by_meshes(meshes)
            ),
            "cpu_s": round(time.process_time() - started, 1),
        }
        print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    main()
