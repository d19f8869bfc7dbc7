"""Edges of a triangle mesh and graphs over them: connected components, fans around points, consistent winding.

All functions take triangles (m, 3) of point indices, none of which repeats an index in one face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from schemas.arrays import BoolArray, IntArray


@dataclass(frozen=True)
class Edges:
    """Undirected edges of `m` triangles; half-edge k of a face runs from its corner k to its corner k + 1.

    points   (e, 2) point indices, the smaller first.
    of_face  (m, 3) edge of each half-edge.
    upward   (m, 3) True where the half-edge runs from the smaller to the larger index.
    uses     (e,) faces at the edge: 1 on a boundary, 2 inside a manifold, more where surfaces meet.
    """

    points: IntArray
    of_face: IntArray
    upward: BoolArray
    uses: IntArray

    @property
    def net(self) -> IntArray:
        """(e,) upward minus downward half-edges; zero everywhere on a closed, consistently wound surface."""
        flat = self.of_face.reshape(-1)
        return np.bincount(flat, np.where(self.upward.reshape(-1), 1, -1), len(self.uses)).astype(np.int64)


def edges_of(triangles: IntArray) -> Edges:
    """The edges of `triangles` (m, 3), none of which may repeat an index."""
    start = triangles.astype(np.int64)
    end = np.roll(start, -1, axis=1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    base = int(high.max()) + 1 if high.size else 1
    keys, of_half, uses = np.unique(low * base + high, return_inverse=True, return_counts=True)
    return Edges(np.stack([keys // base, keys % base], axis=1), of_half.reshape(-1, 3), start < end, uses)


def face_components(edges: Edges, through: BoolArray | None = None) -> tuple[int, IntArray]:
    """Number of edge-connected components and the component (m,) of each face, numbered by first face.

    Only edges where `through` (e,) is True connect; all by default.
    """
    m, e = len(edges.of_face), len(edges.uses)
    faces = np.repeat(np.arange(m), 3)
    links = edges.of_face.reshape(-1)
    if through is not None:
        open_way = through[links]
        faces, links = faces[open_way], links[open_way]
    labels = _components(m + e, faces, links + m)[:m]
    return _numbered_by_first(labels)


def corner_fans(triangles: IntArray, edges: Edges) -> tuple[int, IntArray]:
    """Number of fans and the fan (m, 3) of each corner.

    A fan is a set of faces around one point that are connected by edges at that point. A manifold point has one fan.
    """
    m, e = len(triangles), len(edges.uses)
    corner = np.arange(3 * m).reshape(m, 3)
    ends: list[tuple[IntArray, IntArray]] = []
    for half in range(3):
        edge, upward = edges.of_face[:, half], edges.upward[:, half]
        # Node 3m + 2 edge is the edge's smaller end, 3m + 2 edge + 1 the larger.
        tail, head = 3 * m + 2 * edge + ~upward, 3 * m + 2 * edge + upward
        ends += [(corner[:, half], tail), (corner[:, (half + 1) % 3], head)]
    rows, columns = (np.concatenate(part) for part in zip(*ends, strict=True))
    labels = _components(3 * m + 2 * e, rows, columns)[: 3 * m]
    count, numbered = _numbered_by_first(labels)
    return count, numbered.reshape(m, 3)


def corners_at(triangles: IntArray, points: IntArray) -> list[tuple[IntArray, IntArray]]:
    """For each of `points`: rows (k,) and columns (k,) of the corners that refer to it, in ascending order."""
    flat = triangles.reshape(-1)
    corners = np.flatnonzero(np.isin(flat, points))
    corners = corners[np.argsort(flat[corners], kind="stable")]
    first, last = (np.searchsorted(flat[corners], points, side=side) for side in ("left", "right"))
    return [(corners[a:b] // 3, corners[a:b] % 3) for a, b in zip(first, last, strict=True)]


def consistent_flips(edges: Edges) -> tuple[BoolArray, BoolArray]:
    """Masks (m,): faces to flip so that neighbours agree, and faces on a one-sided (non-orientable) sheet.

    Winding spreads across edges with exactly two faces. In each sheet the minority by count is flipped. Method: a face
    and its reverse are two nodes; neighbours that agree join equal nodes, others crosswise; a sheet can be oriented
    iff its two covers stay apart.
    """
    m = len(edges.of_face)
    flat = edges.of_face.reshape(-1)
    inner = np.flatnonzero(edges.uses[flat] == 2)
    pairs = inner[np.argsort(flat[inner], kind="stable")].reshape(-1, 2)
    first, second = pairs[:, 0] // 3, pairs[:, 1] // 3
    same_way = edges.upward.reshape(-1)[pairs]
    crossed = (same_way[:, 0] == same_way[:, 1]).astype(np.int64)
    rows = np.concatenate([first, first + m])
    columns = np.concatenate([second + m * crossed, second + m * (1 - crossed)])
    labels = _components(2 * m, rows, columns)
    one_sided = labels[:m] == labels[m:]
    cover = labels[:m] > labels[m:]
    _, sheet = _numbered_by_first(np.minimum(labels[:m], labels[m:]))
    turned, size = np.bincount(sheet, cover), np.bincount(sheet)
    flips = np.where(turned[sheet] * 2 > size[sheet], ~cover, cover) & ~one_sided
    return flips, one_sided


def _components(nodes: int, rows: IntArray, columns: IntArray) -> IntArray:
    graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(nodes, nodes))
    return connected_components(graph, directed=False)[1]


def _numbered_by_first(labels: IntArray) -> tuple[int, IntArray]:
    """Labels renumbered 0, 1, ... in order of first appearance, and how many there are."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return len(first), rank[inverse.reshape(-1)]
