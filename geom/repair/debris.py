"""Floating debris of a triangle surface: a mask (m,) of the faces of tiny pieces that touch nothing else."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geom.mesh.surface_distance import NearestOnSurface, triangle_areas
from geom.mesh.topology import FRAGMENT_AREA_SHARE, FRAGMENT_EXTENT_SHARE
from schemas.arrays import BoolArray, FloatArray, IntArray

# Area of all debris together; with more, the surface is made of patches or the object of many parts.
MOST_AREA_SHARE = 0.01
# All pairs of pieces are compared: beyond this many pieces nothing is removed.
MOST_PIECES = 2000


def loose_debris(points: FloatArray, triangles: IntArray) -> BoolArray:
    """(m,) True for the faces of floating debris on a welded surface.

    Pieces are connected through points. A piece is tiny with less than 0.1 % of the area and 2 % of the diagonal of
    what is not tiny. Tiny pieces closer to each other than the larger one's own diagonal form one group; a group floats
    when it is tiny as a whole and every piece is further from the rest of the surface than its own diagonal. Screws,
    buttons and decals sit on something, chains of beads are not tiny as a whole: they stay. So does everything when
    what floats makes up more than 1 % of the area.
    """
    none = np.zeros(len(triangles), dtype=bool)
    label, count = _pieces(triangles, len(points))
    if count < 2:
        return none
    corners = points[triangles]
    areas = triangle_areas(corners)
    area = np.bincount(label, areas, count)
    low, high = _boxes(corners, label, count)
    extent = np.linalg.norm(high - low, axis=1)
    tiny = area < FRAGMENT_AREA_SHARE * area.sum()
    if tiny.all() or not 0 < tiny.sum() <= MOST_PIECES:
        return none
    size = float(np.linalg.norm(high[~tiny].max(axis=0) - low[~tiny].min(axis=0)))
    tiny &= extent < FRAGMENT_EXTENT_SHARE * size
    small = np.flatnonzero(tiny)
    if small.size == 0:
        return none
    group, groups = _groups(low[small], high[small], extent[small])
    tiny_faces = np.flatnonzero(tiny[label])
    rest = NearestOnSurface(points, triangles[~tiny[label]])
    corner = corners[tiny_faces].reshape(-1, 3)
    gaps = np.linalg.norm(rest(corner)[0] - corner, axis=1).reshape(-1, 3).min(axis=1)
    gap = np.full(count, np.inf)
    np.minimum.at(gap, label[tiny_faces], gaps)
    floats = np.ones(groups, dtype=bool)
    np.logical_and.at(floats, group, gap[small] > extent[small])
    group_low, group_high = np.full((groups, 3), np.inf), np.full((groups, 3), -np.inf)
    np.minimum.at(group_low, group, low[small])
    np.maximum.at(group_high, group, high[small])
    floats &= np.linalg.norm(group_high - group_low, axis=1) < FRAGMENT_EXTENT_SHARE * size
    debris = np.zeros(count, dtype=bool)
    debris[small] = floats[group]
    if area[debris].sum() > MOST_AREA_SHARE * area.sum():
        return none
    return debris[label]


def _pieces(triangles: IntArray, points: int) -> tuple[IntArray, int]:
    """The piece (m,) of each face and how many there are."""
    rows, columns = triangles[:, [0, 1]].reshape(-1), triangles[:, [1, 2]].reshape(-1)
    graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(points, points))
    label = connected_components(graph, directed=False)[1][triangles[:, 0]]
    names, label = np.unique(label, return_inverse=True)
    return label.reshape(-1), len(names)


def _boxes(corners: FloatArray, label: IntArray, count: int) -> tuple[FloatArray, FloatArray]:
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    return low, high


def _groups(low: FloatArray, high: FloatArray, extent: FloatArray) -> tuple[IntArray, int]:
    """The group (k,) of each box, joined where two are closer than the larger one's diagonal; how many there are."""
    between = np.maximum(0.0, np.maximum(low[:, None] - high[None], low[None] - high[:, None]))
    near = np.linalg.norm(between, axis=2) <= np.maximum(extent[:, None], extent[None])
    groups, group = connected_components(near, directed=False)
    return group, groups
