"""Stitching of T-junctions: points on the side of a neighbouring face, which is split so that they become corners."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from geom.mesh.components import components_of
from geom.mesh.edges import Edges, edges_of
from geom.mesh.edit import remix_faces
from geom.mesh.weld import diagonal
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

Figures = dict[str, float]
# Single-precision files round at 6e-8 of their extent.
ON_SIDE_PER_DIAGONAL = 1e-6
# A face is split at one side at a time; chains of small triangles need a few rounds.
SPLIT_ROUNDS = 8


def stitch_t_junctions(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) whose open sides are split at the open points that lie on them.

    The result is used only if it closes components: panels that merely lie side by side are unchanged. No point moves;
    new corners get the interpolated attributes of the side. Figures: `t_junctions` stitched.
    """
    stitched, count = mesh, 0
    for _ in range(SPLIT_ROUNDS):
        stitched, split_points = _split_once(stitched)
        if not split_points:
            break
        count += split_points
    if count and _open_area(stitched) < _open_area(mesh):
        return stitched, {"t_junctions": count}
    return mesh, {"t_junctions": 0}


def _split_once(mesh: Mesh) -> tuple[Mesh, int]:
    """The mesh with every face split at one of its sides where points lie on it, and the number of these points."""
    edges = edges_of(mesh.triangles)
    split_sides = _points_on_sides(mesh.points, mesh.triangles, edges)
    sides: dict[int, tuple[int, IntArray, FloatArray]] = {}
    for face, side, points, at in split_sides:
        sides.setdefault(face, (side, points, at))
    if not sides:
        return mesh, 0
    triangles: list[list[int]] = []
    source: list[int] = []
    weights: list[FloatArray] = []
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
    unsplit = np.setdiff1d(np.arange(len(mesh.triangles)), list(sides))
    whole = np.broadcast_to(np.eye(3), (len(unsplit), 3, 3))
    split = remix_faces(
        mesh,
        np.concatenate([mesh.triangles[unsplit], np.array(triangles, dtype=np.int32)]),
        np.concatenate([unsplit, np.array(source)]),
        np.concatenate([whole, np.array(weights)]),
    )
    return split, sum(len(points) for _, points, _ in sides.values())


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
    split_sides: list[tuple[int, int, IntArray, FloatArray]] = []
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
            split_sides.append((int(face[i]), int(side[i]), candidates[on][order], at[on][order]))
    return split_sides


def _open_area(mesh: Mesh) -> float:
    parts = components_of(mesh.points, mesh.triangles)
    return float(parts.area[~parts.closed].sum())
