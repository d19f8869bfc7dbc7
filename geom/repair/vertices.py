"""Splitting of non-manifold vertices at which solids touch, so that each fan of faces has its own point."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from geom.mesh.edges import corner_fans, corners_at, edges_of
from geom.mesh.surface_distance import closest_on_surface
from geom.mesh.topology import bow_ties
from geom.mesh.weld import diagonal
from geom.mesh.winding_number import winding_numbers
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

Figures = dict[str, float]
# Two cones that come closer than this angle (radians) share a face or an edge: the parts lie against each other.
CONTACT_ANGLE = 0.05
PROBE_LENGTH = 1e-3
PART_PER_DIAGONAL = 1e-5


def split_bow_ties(mesh: Mesh, vertices: IntArray) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) in which each fan of faces at `vertices` has a point of its own.

    Each such point moves into its own fan by 1e-5 of the diagonal, so that no later welding joins them again.
    Figures: `split_points`, the points added.
    """
    _, fan = corner_fans(mesh.triangles, edges_of(mesh.triangles))
    split = split_fans(mesh, vertices, fan)
    return split, {"split_points": len(split.points) - len(mesh.points) - len(vertices)}


def split_fans(mesh: Mesh, vertices: IntArray, fan: IntArray) -> Mesh:
    """`mesh` in which each `fan` (m, 3) of corners at `vertices` has a point of its own, moved into it."""
    points, triangles = [mesh.points], mesh.triangles.copy()
    for vertex, (rows, columns) in zip(vertices, corners_at(mesh.triangles, vertices), strict=True):
        labels = fan[rows, columns]
        for label in np.unique(labels):
            in_fan = labels == label
            cone = _cone(mesh.points, mesh.triangles[rows[in_fan]], columns[in_fan], int(vertex))
            inward = cone[:, 1:].reshape(-1, 3).mean(axis=0)
            triangles[rows[in_fan], columns[in_fan]] = len(mesh.points) + len(points) - 1
            points.append(mesh.points[vertex] + PART_PER_DIAGONAL * diagonal(mesh.points) * inward[None])
    return replace(mesh, points=np.concatenate(points), triangles=triangles)


def touching_points(points: FloatArray, triangles: IntArray) -> IntArray:
    """Points (b,) in which two closed, outward fans of faces touch in that point alone.

    This is a defect of one solid or two. Parts that lie against each other with a face or an edge, and parts that
    penetrate, also share single points by design; so do voxel models, recognised by edges with more than two faces.
    """
    edges = edges_of(triangles)
    if (edges.uses != 2).any():
        return np.zeros(0, dtype=np.int64)
    _, fan = corner_fans(triangles, edges)
    ties = bow_ties(triangles, edges)
    alone = [
        _touches_alone(points, triangles, fan[rows, columns], rows, columns)
        for rows, columns in corners_at(triangles, ties)
    ]
    return ties[np.array(alone, dtype=bool)]


def _touches_alone(
    points: FloatArray, triangles: IntArray, labels: IntArray, rows: IntArray, columns: IntArray
) -> bool:
    """`labels` (k,) are the fans of the corners `rows`, `columns` (k,) around one point."""
    vertex = int(triangles[rows[0], columns[0]])
    cones = [
        _cone(points, triangles[rows[labels == label]], columns[labels == label], vertex) for label in np.unique(labels)
    ]
    return all(_cones_apart(a, b) for a, b in combinations(cones, 2))


def _cone(points: FloatArray, faces: IntArray, columns: IntArray, vertex: int) -> FloatArray:
    """Triangles (k, 3, 3) from the origin to the unit directions of each face's two edges at the vertex."""
    index = np.arange(len(faces))
    ends = np.stack([points[faces[index, (columns + k) % 3]] - points[vertex] for k in (1, 2)], axis=1)
    ends /= np.linalg.norm(ends, axis=2, keepdims=True)
    return np.concatenate([np.zeros((len(faces), 1, 3)), ends], axis=1)


def _cones_apart(a: FloatArray, b: FloatArray) -> bool:
    """True iff the cones meet at the apex only: no direction of one lies on or inside the other."""
    for mine, other in ((a, b), (b, a)):
        probes = np.concatenate([mine[:, 1], mine[:, 1] + mine[:, 2]])
        probes = 0.5 * probes / np.linalg.norm(probes, axis=1, keepdims=True)
        nearest, _ = closest_on_surface(probes, other.reshape(-1, 3), np.arange(3 * len(other)).reshape(-1, 3))
        if np.linalg.norm(nearest - probes, axis=1).min() < 0.5 * CONTACT_ANGLE:
            return False
        # Near the apex an outward cone of solid angle w winds by 1 - w / 4 pi about its inside, -w / 4 pi outside.
        if (winding_numbers(PROBE_LENGTH * probes, other) > 0.0).any():
            return False
    return True
