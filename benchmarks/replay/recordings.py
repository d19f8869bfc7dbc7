"""Replay augmentation on recorded episodes: cost and tightness of the envelope, checks beside PyBullet, variants.

    OMP_NUM_THREADS=1 python -m benchmarks.replay.recordings EPISODES --assets LIBRARY

For each recording: CPU seconds of the envelope; by link its volume over that of the densely swept hull with clearance,
more than 0.4 m from the base (points drawn evenly in the envelope, four times between rows); spots of a box on the
supports judged by the envelope and by PyBullet, which replays every row and computes closest points; objects put into
variants. Everything is drawn from fixed seeds.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pybullet
import shapely
import trimesh
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from shapely.geometry import Polygon

from cli.replay.candidates import candidates
from geom.convex.circumscribed_hull import circumscribed_hull
from geom.minkowski import eroded
from geom.pose import pose
from replay.augmentation import PreparedEpisode, prepare, variants
from replay.envelope.envelope import Envelope, Settings
from replay.recording.episode import Episode
from replay.recording.formats.read import is_recording, read_episode
from replay.verification.dense import dense_motion
from replay.views.visible_area import in_picture
from schemas.arrays import BoolArray, FloatArray
from schemas.physics import CollisionShape
from sim.bullet.shapes import clear_margins, compound
from sim.bullet.world import private_client

BOX_M = (0.06, 0.06, 0.1)
FAR_M, POINTS, SPOTS, TRUE_M = 0.4, 400, 150, 0.02
# Which points (k, 3) a body of this name comes near to at poses X_WB (p, 4, 4); None where its form is not known.
Reached = Callable[[str, FloatArray, FloatArray], BoolArray | None]


def tightness(episode: Episode, envelope: Envelope, reached: Reached) -> dict[str, float]:
    """By body the volume of its capsules over that of what its sweep reaches, away from every base.

    The sweep is that of four times an interval, by both paths.
    """
    swept: dict[str, list[FloatArray]] = {}
    for stretch in dense_motion(episode, 4):
        for body in stretch.bodies:
            swept.setdefault(body.name, []).append(body.X_WB)
    rng, ratios = np.random.default_rng(0), {}
    bases = [robot.X_WR[0, :2, 3] for robot in episode.robots]
    for number, name in enumerate(envelope.bodies):
        mine = envelope.body == number
        points = inside(envelope.start_W[mine], envelope.end_W[mine], envelope.radius_m[mine], bases, rng)
        if len(points) >= POINTS // 4:
            hits = reached(name, points, np.concatenate(swept[name]))
            if hits is not None:
                ratios[name] = round(len(points) / max(int(hits.sum()), 1), 2)
    return ratios


def by_shapes(episode: Episode, clearance_m: float) -> Reached:
    """What comes within the clearance of the shapes that were read."""
    shapes = {body.name: body.shapes for body in next(dense_motion(episode, 1)).bodies}
    return lambda name, points, X_WB: _swept(points, X_WB, shapes[name], clearance_m)


def inside(
    a: FloatArray, b: FloatArray, radius: FloatArray, bases: list[FloatArray], rng: np.random.Generator
) -> FloatArray:
    """Points (k, 3) drawn evenly from capsules' union beyond `FAR_M` of the bases."""
    low, high = (np.minimum(a, b) - radius[:, None]).min(axis=0), (np.maximum(a, b) + radius[:, None]).max(axis=0)
    points_inside: list[FloatArray] = []
    for _ in range(200):
        points = rng.uniform(low, high, (200, 3))
        far = np.logical_and.reduce(
            [np.linalg.norm(points[:, :2] - base, axis=1) > FAR_M for base in bases] or [np.ones(200, bool)]
        )
        points = points[far]
        along = b - a
        share = np.einsum("pci,ci->pc", points[:, None] - a, along) / np.maximum((along**2).sum(axis=1), 1e-300)
        near = a + np.clip(share, 0.0, 1.0)[:, :, None] * along
        points_inside += list(points[(np.linalg.norm(points[:, None] - near, axis=2) <= radius).any(axis=1)])
        if len(points_inside) >= POINTS:
            break
    return np.array(points_inside[:POINTS])


def _swept(points: FloatArray, X_WB: FloatArray, shapes: tuple[CollisionShape, ...], clearance_m: float) -> BoolArray:
    """Which points come within the clearance of the moving shapes at some pose."""
    hit = np.zeros(len(points), dtype=bool)
    for shape in shapes:
        corners = circumscribed_hull(shape)
        hull = ConvexHull(corners)
        sides = corners[hull.simplices]
        for X in X_WB:
            left = np.flatnonzero(~hit)
            local = (points[left] - X[:3, 3]) @ X[:3, :3]
            beyond = (local @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
            hit[left[beyond <= 0.0]] = True
            near = np.flatnonzero((beyond > 0.0) & (beyond <= clearance_m))
            if len(near):
                asked = np.repeat(local[near], len(sides), axis=0)
                apart = trimesh.triangles.closest_point(np.tile(sides, (len(near), 1, 1)), asked) - asked
                distance = np.linalg.norm(apart, axis=1).reshape(len(near), -1).min(axis=1)
                hit[left[near[distance <= clearance_m]]] = True
    return hit


def spots(prepared: PreparedEpisode) -> dict[str, float]:
    """A box at spots on the supports: admitted by us or not, by PyBullet or not, and both costs."""
    rng, rows = np.random.default_rng(1), []
    half = np.array(BOX_M) / 2.0
    outline = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half[:2]
    cost, checked = 0.0, 0
    for site in prepared.sites:
        support = site.free_space.support
        started = time.process_time()
        region = eroded(site.free_space.free(BOX_M[2]), outline)
        shapely.prepare(region)
        places = rng.uniform(support.area.bounds[:2], support.area.bounds[2:], (200_000, 2))
        ours = shapely.contains_xy(region, places)
        cost, checked = cost + time.process_time() - started, checked + len(places)
        inner = shapely.contains_xy(eroded(support.area, outline), places)
        some = np.flatnonzero(inner)[:SPOTS]
        walls = [
            w.outline
            for w in site.free_space.obstacles
            if w.high_m > support.height_m + 1e-3 and w.low_m < support.height_m + BOX_M[2]
        ]
        beside = shapely.union_all(walls)
        for k in some:
            apart = Polygon(outline + places[k]).distance(beside) if walls else np.inf
            rows.append((*places[k], support.height_m + half[2], bool(ours[k]), apart))
    started = time.process_time()
    near = _closest(prepared.episode, np.array([row[:3] for row in rows]))
    theirs = time.process_time() - started
    near = np.minimum(near, [row[4] for row in rows])
    ours = np.array([row[3] for row in rows])
    clear = near >= TRUE_M
    return {
        "spots": len(rows),
        "admitted": int(ours.sum()),
        "admitted_that_pybullet_rejects": int((ours & (near < prepared.envelope.clearance_m)).sum()),
        "clear_by_2cm": int(clear.sum()),
        "of_these_refused": int((clear & ~ours).sum()),
        "checks_per_cpu_s": checked / cost,
        "pybullet_checks_per_cpu_s": len(rows) / theirs,
        "ratio": checked / cost / (len(rows) / theirs),
    }


def _closest(episode: Episode, centres: FloatArray) -> FloatArray:
    """Least distance of the box from everything that moves, at every row; capped at 3 cm."""
    least = np.full(len(centres), 0.03)
    with private_client() as client, tempfile.TemporaryDirectory() as folder:
        pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)  # hulls share a file name
        half = [side / 2.0 for side in BOX_M]
        box = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
        clear_margins(box, 1, client)
        probe = pybullet.createMultiBody(0.0, box, physicsClientId=client)
        handles: dict[str, int] = {}
        for stretch in dense_motion(episode, 1):
            for body in stretch.bodies:
                if body.name not in handles:
                    shape = compound(body.shapes, 1.0, Path(folder), client)
                    clear_margins(shape, len(body.shapes), client)
                    handles[body.name] = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
            for row in range(len(stretch.t_s)):
                for body in stretch.bodies:
                    _pose(handles[body.name], body.X_WB[row], client)
                for k, centre in enumerate(centres):
                    _pose(probe, pose(None, centre), client)
                    for handle in handles.values():
                        found = pybullet.getClosestPoints(
                            probe, handle, float(max(least[k], 0.0)), physicsClientId=client
                        )
                        least[k] = min([least[k], *(point[8] for point in found)])
    return least


def _pose(handle: int, X: FloatArray, client: int) -> None:
    quat = Rotation.from_matrix(X[:3, :3]).as_quat().tolist()
    pybullet.resetBasePositionAndOrientation(handle, X[:3, 3].tolist(), quat, physicsClientId=client)


def put_in(prepared: PreparedEpisode, assets: Path, count: int) -> dict[str, float]:
    """Variants with three packages each: how many objects, in the picture of a camera, at what cost."""
    draw, _ = candidates(None, assets)
    started = time.process_time()
    made_variants = list(variants(prepared, draw, range(count), 3, 0, assets))
    cpu_s = time.process_time() - started
    places = [one.position_m for variant in made_variants for one in variant.inserted]
    cameras = prepared.episode.cameras
    seen = [any(in_picture(camera, np.array([place])) for camera in cameras) for place in places]
    return {
        "variants": count,
        "with_three_objects": sum(len(variant.inserted) >= 3 for variant in made_variants),
        "objects": len(places),
        "in_a_picture": sum(seen),
        "distinct_poses": len(set(places)),
        "cpu_s_per_variant": cpu_s / count,
    }


def main() -> None:
    """Print one JSON document a recording."""
    parser = argparse.ArgumentParser()
    parser.add_argument("episodes", type=Path)
    parser.add_argument("--assets", type=Path, required=True)
    parser.add_argument("--variants", type=int, default=200)
    given = parser.parse_args()
    folders = [given.episodes] if is_recording(given.episodes) else sorted(given.episodes.iterdir())
    for folder in [path for path in folders if is_recording(path)]:
        episode = read_episode(folder)
        started = time.process_time()
        prepared = prepare(episode, Settings())
        report = {"episode": episode.name, "rows": len(episode.t_s), "capsules": len(prepared.envelope.body)}
        report["envelope_cpu_s"] = time.process_time() - started
        report |= {"variants": put_in(prepared, given.assets, given.variants), "spots": spots(prepared)}
        report["volume_ratio"] = tightness(episode, prepared.envelope, by_shapes(episode, Settings().clearance_m))
        print(json.dumps(report, indent=1), flush=True)


if __name__ == "__main__":
    main()
