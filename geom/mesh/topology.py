"""Topology of a triangle mesh as counts: components, open and non-manifold edges, degenerate and duplicate faces."""

from __future__ import annotations

import numpy as np

from geom.mesh.components import Components, components_of, opposite_container
from geom.mesh.duplicate_shells import later_copies, surplus_shells
from geom.mesh.edges import Edges, corner_fans, edges_of
from geom.mesh.weld import diagonal, weld_points
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.asset import Topology

# A face whose height is below this share of its longest edge has no area in single precision.
FLAT_HEIGHT_PER_EDGE = 1e-6
FRAGMENT_AREA_SHARE = 1e-3
FRAGMENT_EXTENT_SHARE = 0.02
THIN_EXTENT_SHARE = 0.01
SOUP_LEAST_FACES = 20


def observe(points: FloatArray, triangles: IntArray, name: str) -> Topology:
    """The counts of a surface after welding equal points; points (n, 3) and triangles (m, 3), free of NaN.

    Degenerate faces repeat a point or have a height below 1e-6 of their longest edge; duplicates share their three
    points with an earlier face. Faces that repeat a point take no part in the edge counts. Runs in near-linear time.
    """
    points, triangles = weld_points(points, triangles)
    proper = triangles[~repeats_point(triangles)]
    edges = edges_of(proper)
    parts = components_of(points, proper, edges)
    parent = opposite_container(points, proper, parts)
    watertight = len(proper) > 0 and bool(parts.closed.all())
    return Topology(
        name=name,
        points=len(points),
        triangles=len(triangles),
        extent=_extent(points),
        components=parts.count,
        degenerate_faces=int(degenerate_faces(points, triangles).sum()),
        duplicate_faces=int(duplicate_faces(proper).sum()),
        boundary_edges=int((edges.uses == 1).sum()),
        non_manifold_edges=int((edges.uses > 2).sum()),
        non_manifold_vertices=len(bow_ties(proper, edges)),
        inconsistent_edges=int(((edges.uses == 2) & (edges.net != 0)).sum()),
        inverted=bool((parts.inside_out & (parent < 0)).any()),
        watertight=watertight,
        duplicate_shells=surplus_shells(points, proper, parts)[0],
        inner_shells=int(((parent >= 0) & (parts.volume < 0.0)).sum()),
        fragments=int(fragments(parts, diagonal(points)).sum()),
        thin_parts=_count_thin(points, proper, parts),
        area=float(parts.area.sum()),
        volume=float(parts.volume.sum()) if watertight else None,
    )


def is_triangle_soup(topology: Topology) -> bool:
    """True iff no two faces share an edge and there are more than 20 faces: separate triangles, no surface."""
    faces = topology.triangles - topology.degenerate_faces
    return faces > SOUP_LEAST_FACES and topology.boundary_edges >= 3 * faces and topology.components >= faces


def is_all_degenerate(topology: Topology) -> bool:
    """True iff there are faces and none of them has area."""
    return topology.triangles > 0 and topology.degenerate_faces == topology.triangles


def repeats_point(triangles: IntArray) -> BoolArray:
    """(m,) True where a face repeats a point."""
    a, b, c = triangles.T
    return (a == b) | (b == c) | (c == a)


def degenerate_faces(points: FloatArray, triangles: IntArray) -> BoolArray:
    """(m,) True where a face repeats a point or is flatter than 1e-6 of its longest edge."""
    corners = points[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.einsum("mkx,mkx->mk", sides, sides).max(axis=1, initial=0.0)
    twice_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return repeats_point(triangles) | (twice_area <= FLAT_HEIGHT_PER_EDGE * longest)


def duplicate_faces(triangles: IntArray) -> BoolArray:
    """(m,) True where an earlier face has the same three points, in any order."""
    return later_copies(np.sort(triangles, axis=1))


def bow_ties(triangles: IntArray, edges: Edges) -> IntArray:
    """Points (b,) whose faces form more than one fan."""
    fans, fan = corner_fans(triangles, edges)
    point_of_fan = np.zeros(fans, dtype=np.int64)
    point_of_fan[fan.reshape(-1)] = triangles.reshape(-1)
    return np.flatnonzero(np.bincount(point_of_fan) > 1)


def fragments(parts: Components, whole_diagonal: float) -> BoolArray:
    """(k,) True for components with < 0.1 % of the area and < 2 % of the diagonal; never all of them."""
    small = (parts.area < FRAGMENT_AREA_SHARE * parts.area.sum()) & (
        parts.extent < FRAGMENT_EXTENT_SHARE * whole_diagonal
    )
    return small & ~small.all() if small.size else small


def _extent(points: FloatArray) -> tuple[float, float, float]:
    x, y, z = np.ptp(points, axis=0) if len(points) else np.zeros(3)
    return float(x), float(y), float(z)


def _count_thin(points: FloatArray, triangles: IntArray, parts: Components) -> int:
    """Components whose least extent in their principal axes is below 1 % of the largest."""
    pairs = np.unique(np.repeat(parts.label, 3) * len(points) + triangles.reshape(-1))
    label, component_points = pairs // max(len(points), 1), points[pairs % max(len(points), 1)]
    count = np.maximum(np.bincount(label, minlength=parts.count), 1)
    centre = np.stack([np.bincount(label, component_points[:, k], parts.count) / count for k in range(3)], axis=1)
    component_points = component_points - centre[label]
    spread = np.empty((parts.count, 3, 3))
    for i in range(3):
        for j in range(3):
            spread[:, i, j] = np.bincount(label, component_points[:, i] * component_points[:, j], parts.count)
    turned = np.einsum("kx,kxy->ky", component_points, np.linalg.eigh(spread)[1][label])
    low, high = np.full((parts.count, 3), np.inf), np.full((parts.count, 3), -np.inf)
    np.minimum.at(low, label, turned)
    np.maximum.at(high, label, turned)
    size = high - low
    return int((size.min(axis=1, initial=np.inf) < THIN_EXTENT_SHARE * size.max(axis=1, initial=0.0)).sum())
