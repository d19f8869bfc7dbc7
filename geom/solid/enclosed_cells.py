"""The cells that a surface with crowded edges encloses, and the faces that enclose nothing.

Household models draw panels that share edges: the walls of a carcass meet in edges with three or four faces, walls are
drawn twice, one board hangs on the edge of another. Winding says nothing there. The two sides of all faces, linked
around every edge, fall into one group per region of space; a group with a positive volume bounds a cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geom.mesh.components import MIN_COMPACTNESS
from geom.mesh.duplicate_shells import row_numbers
from geom.mesh.edges import Edges, edges_of
from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class EnclosedCells:
    """The bodies of a surface of `m` faces.

    bodies  closed outward triangles (k, 3) of each group of cells that share faces; those faces are left out.
    sheets  (m,) True for faces that neither bound a body nor lie in one.
    """

    bodies: tuple[IntArray, ...]
    sheets: BoolArray


def enclosed_cells(points: FloatArray, triangles: IntArray) -> EnclosedCells:
    """The bodies that `triangles` (m, 3) of welded `points` (n, 3) enclose, none of which may repeat an index.

    Every cell is solid, except one all of whose faces are wound into it and border other cells: that is a cavity. The
    surface should cross itself nowhere but in its edges; where it does, cells are those of the connectivity. Faces with
    the same three points count once. Idea: the cell complex of Zhou, Grinspun, Zorin and Jacobson 2016, "Mesh
    arrangements for solid geometry", without the resolution of crossings.
    """
    _, first, of_face = np.unique(row_numbers(np.sort(triangles, axis=1)), return_index=True, return_inverse=True)
    once = triangles[first]
    m = len(once)
    label = _linked_sides(points, once, edges_of(once))
    front, back = label[:m], label[m:]
    corners = points[once] - 0.5 * (points.min(axis=0) + points.max(axis=0))
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    areas = triangle_areas(corners)
    count = int(label.max(initial=-1)) + 1
    # A cell lies in front of the faces whose front side is in its group: seen from within, these are inside out.
    volume = np.bincount(back, volumes, count) - np.bincount(front, volumes, count)
    area = np.bincount(back, areas, count) + np.bincount(front, areas, count)
    solid = volume > MIN_COMPACTNESS * area**1.5
    beside = solid[front] & solid[back] & (front != back)
    cavity = solid.copy()
    cavity[back] = False
    cavity[front[~beside]] = False
    solid &= ~cavity
    skin = solid[front] ^ solid[back]
    outward = np.where(solid[back][:, None], once, once[:, [0, 2, 1]])
    owner = np.where(solid[back], back, front)
    inner = np.flatnonzero(solid[front] & solid[back])
    graph = coo_array((np.ones(len(inner), dtype=bool), (front[inner], back[inner])), shape=(count, count))
    cluster = connected_components(graph, directed=False)[1][owner]
    bodies = tuple(outward[skin & (cluster == k)] for k in np.unique(cluster[skin]))
    return EnclosedCells(bodies, (~solid[front] & ~solid[back])[of_face])


def _linked_sides(points: FloatArray, triangles: IntArray, edges: Edges) -> IntArray:
    """(2 m,) group of the front of each face, then of each back: sides that see each other around an edge are linked.

    Around an edge the faces are sorted by angle; the side of each that looks counterclockwise sees the clockwise side
    of the next. At the edge of a sheet front and back see each other.
    """
    m = len(triangles)
    edge = edges.of_face.reshape(-1)
    face = np.repeat(np.arange(m), 3)
    upward = edges.upward.reshape(-1)
    opposite = points[np.roll(triangles, 1, axis=1).reshape(-1)]
    order = np.lexsort((_angles(points, edges, edge, opposite), edge))
    counterclockwise = np.where(upward, face, face + m)[order]
    clockwise = np.where(upward, face + m, face)[order]
    first = np.cumsum(edges.uses) - edges.uses
    following = np.arange(len(order)) + 1
    following[first + edges.uses - 1] = first
    graph = coo_array((np.ones(len(order), dtype=bool), (counterclockwise, clockwise[following])), shape=(2 * m, 2 * m))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _angles(points: FloatArray, edges: Edges, edge: IntArray, opposite: FloatArray) -> FloatArray:
    """(h,) angle (rad) of the point `opposite` (h, 3) each `edge` (h,), about the edge from its smaller end."""
    start = points[edges.points[:, 0]]
    axis = points[edges.points[:, 1]] - start
    axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), np.finfo(float).tiny)
    across = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    u = np.cross(axis, across)
    u /= np.maximum(np.linalg.norm(u, axis=1, keepdims=True), np.finfo(float).tiny)
    v = np.cross(axis, u)
    away = opposite - start[edge]
    return np.arctan2(np.einsum("ij,ij->i", away, v[edge]), np.einsum("ij,ij->i", away, u[edge]))
