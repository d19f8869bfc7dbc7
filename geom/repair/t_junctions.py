"""Stitch T-junctions: points that lie on the side of a neighbouring face instead of being its corner."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from geom.mesh.components import components_of
from geom.mesh.edges import Edges, edges_of
from geom.mesh.edit import remix_faces
from geom.mesh.weld import diagonal
from schemas.model import FloatArray, IntArray, Mesh

Figures = dict[str, float]
# Single-precision files round at 6e-8 of their extent.
ON_SIDE_PER_DIAGONAL = 1e-6
# A face is split at one side at a time; chains of small triangles need a few rounds.
ROUNDS = 8


def stitch_t_junctions(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) whose open sides are split at the open points that lie on them.

    Kept only where it closes components: panels that merely lie side by side stay as they are. Nothing moves; corners
    at the split get the attributes of the side there. Figures: `t_junctions` stitched.
    """
    stitched, count = mesh, 0
    for _ in range(ROUNDS):
        stitched, found = _split_once(stitched)
        if not found:
            break
        count += found
    if count and _open_area(stitched) < _open_area(mesh):
        return stitched, {"t_junctions": count}
    return mesh, {"t_junctions": 0}


def _split_once(mesh: Mesh) -> tuple[Mesh, int]:
    """Every face split at one of its sides, if points lie on it; how many points that were."""
    edges = edges_of(mesh.triangles)
    found = _points_on_sides(mesh.points, mesh.triangles, edges)
    sides: dict[int, tuple[int, IntArray, FloatArray]] = {}
    for face, side, points, at in found:
        sides.setdefault(face, (side, points, at))
    if not sides:
        return mesh, 0
    triangles, source, weights = [], [], []
    for face, (side, points, at) in sides.items():
        corner = [side, (side + 1) % 3, (side + 2) % 3]
        a, b, c = (int(mesh.triangles[face, k]) for k in corner)
        chain, along = [a, *points.tolist(), b], [0.0, *at.tolist(), 1.0]
        for i in range(len(chain) - 1):
            triangles.append([chain[i], chain[i + 1], c])
            weight = np.zeros((3, 3))
            for row, s in enumerate(along[i : i + 2]):
                weight[row, corner[0]], weight[row, corner[1]] = 1.0 - s, s
            weight[2, corner[2]] = 1.0
            weights.append(weight)
            source.append(face)
    kept = np.setdiff1d(np.arange(len(mesh.triangles)), list(sides))
    whole = np.broadcast_to(np.eye(3), (len(kept), 3, 3))
    made = remix_faces(
        mesh,
        np.concatenate([mesh.triangles[kept], np.array(triangles, dtype=np.int32)]),
        np.concatenate([kept, np.array(source)]),
        np.concatenate([whole, np.array(weights)]),
    )
    return made, sum(len(points) for _, points, _ in sides.values())


def _points_on_sides(
    points: FloatArray, triangles: IntArray, edges: Edges
) -> list[tuple[int, int, IntArray, FloatArray]]:
    """Open sides with open points on them: face, side, the points in order and where they lie (0 to 1)."""
    tolerance = ON_SIDE_PER_DIAGONAL * diagonal(points)
    face, side = np.nonzero(edges.uses[edges.of_face] == 1)
    tail, head = triangles[face, side], triangles[face, (side + 1) % 3]
    rim = np.unique(np.concatenate([tail, head]))
    if len(rim) == 0:
        return []
    tree = KDTree(points[rim])
    middle, half = 0.5 * (points[tail] + points[head]), 0.5 * np.linalg.norm(points[head] - points[tail], axis=1)
    near = tree.query_ball_point(middle, half)  # Finds the ends or not, by rounding.
    found = []
    for i in range(len(near)):
        candidates = rim[np.array(near[i], dtype=np.int64)]
        candidates = candidates[(candidates != tail[i]) & (candidates != head[i])]
        if len(candidates) == 0:
            continue
        way = points[head[i]] - points[tail[i]]
        at = (points[candidates] - points[tail[i]]) @ way / (way @ way)
        off = np.linalg.norm(points[tail[i]] + at[:, None] * way - points[candidates], axis=1)
        margin = tolerance / max(2.0 * half[i], tolerance)
        on = (off <= tolerance) & (at > margin) & (at < 1.0 - margin)
        if on.any():
            order = np.argsort(at[on], kind="stable")
            found.append((int(face[i]), int(side[i]), candidates[on][order], at[on][order]))
    return found


def _open_area(mesh: Mesh) -> float:
    parts = components_of(mesh.points, mesh.triangles)
    return float(parts.area[~parts.closed].sum())
