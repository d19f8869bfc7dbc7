"""Splits a model into its far-apart objects, by gaps between the bounding boxes of connected surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from geom.mesh.edit import keep_faces, only_used_points
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh, Model

FAR_APART = 0.25  # Gap between bounding boxes, as a fraction of the smaller object's diagonal.
FRAGMENT = 0.05  # Below this fraction of the largest piece's diagonal, a piece belongs to its nearest neighbour.
_MAX_PIECES = 2000  # Beyond, pairwise distances cost more than the answer is worth; treated as one object.


def split_objects(model: Model) -> tuple[Model, ...]:
    """The separate objects of a model, largest first; `(model,)` when it is one.

    Connected pieces of surface whose bounding boxes lie closer than `FAR_APART` belong together. Meshes are cut along
    these groups; materials and textures are kept where used.
    """
    pieces = [_face_pieces(mesh) for mesh in model.meshes]
    boxes = [_boxes(mesh, labels) for mesh, labels in zip(model.meshes, pieces, strict=True)]
    lows = np.concatenate([b[0] for b in boxes])
    highs = np.concatenate([b[1] for b in boxes])
    if not 1 < len(lows) <= _MAX_PIECES:
        return (model,)
    group_of_piece = _groups(lows, highs)
    if group_of_piece.max() == 0:
        return (model,)
    offsets = np.cumsum([0, *(len(b[0]) for b in boxes)])
    groups = []
    for group in range(group_of_piece.max() + 1):
        meshes = []
        for mesh, labels, offset in zip(model.meshes, pieces, offsets[:-1], strict=True):
            keep = group_of_piece[offset + labels] == group
            if keep.any():
                meshes.append(only_used_points(keep_faces(mesh, keep)))
        groups.append(_with_meshes(model, meshes))
    return tuple(sorted(groups, key=lambda m: -_diagonal(m)))


def _face_pieces(mesh: Mesh) -> IntArray:
    """(m,) label of the connected piece of each face; points that coincide exactly count as one."""
    _, point = np.unique(mesh.points, axis=0, return_inverse=True)
    corners = point.reshape(-1)[mesh.triangles]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]])
    n = len(mesh.points)
    graph = coo_matrix((np.ones(len(edges), bool), (edges[:, 0], edges[:, 1])), shape=(n, n))
    labels = connected_components(graph, directed=False)[1][corners[:, 0]]
    return np.unique(labels, return_inverse=True)[1].reshape(-1)


def _boxes(mesh: Mesh, labels: IntArray) -> tuple[FloatArray, FloatArray]:
    """Bounding boxes (k, 3), (k, 3) of the pieces of a mesh."""
    count = int(labels.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    corners = mesh.points[mesh.triangles]
    np.minimum.at(low, labels, corners.min(axis=1))
    np.maximum.at(high, labels, corners.max(axis=1))
    return low, high


def _groups(low: FloatArray, high: FloatArray) -> IntArray:
    """(k,) group of each box: close boxes together, fragments with their nearest neighbour."""
    diagonal = np.linalg.norm(high - low, axis=1)
    between = np.maximum(0.0, np.maximum(low[:, None] - high[None], low[None] - high[:, None]))
    gap = np.linalg.norm(between, axis=2)
    near = gap <= FAR_APART * np.minimum(diagonal[:, None], diagonal[None])
    for piece in np.flatnonzero(diagonal < FRAGMENT * diagonal.max()):
        others = gap[piece].copy()
        others[diagonal < FRAGMENT * diagonal.max()] = np.inf
        near[piece, int(np.argmin(others))] = True
    return connected_components(near, directed=False)[1]


def _with_meshes(model: Model, meshes: Sequence[Mesh]) -> Model:
    """The model reduced to these meshes and the materials they use; textures are dropped when writing."""
    used = sorted({m.material for m in meshes if m.material is not None})
    index = {old: new for new, old in enumerate(used)}
    return replace(
        model,
        meshes=tuple(replace(m, material=None if m.material is None else index[m.material]) for m in meshes),
        materials=tuple(model.materials[i] for i in used),
    )


def _diagonal(model: Model) -> float:
    points = np.concatenate([m.points for m in model.meshes])
    return float(np.linalg.norm(np.ptp(points, axis=0)))
