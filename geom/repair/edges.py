"""Splitting of non-manifold edges along which solids touch, so that each wedge of solid has its own edge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geom.mesh.edges import Edges, corner_fans, edges_of
from geom.mesh.weld import weld
from geom.repair.vertices import CONTACT_ANGLE, split_fans
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.model import Mesh

Figures = dict[str, float]
# With more such edges the mesh is a voxel model and stays as it is.
MOST_TOUCHING_SHARE = 0.05


def split_touching_edges(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) whose solids no longer share single edges. Figures: `split_edges`.

    An edge is split where its faces bound separate wedges of solid: in turning order about the edge they alternate
    between leaving and entering matter, and no two lie against each other. Each wedge gets points of its own, moved
    into it by 1e-5 of the diagonal, so that no later welding joins them again. Parts in contact share whole faces and
    are unchanged; so are voxel models, in which more than 5 % of the edges are such. Source of the idea: Guéziec,
    Taubin, Lazarus and Horn 2001, "Cutting and stitching".
    """
    edges = edges_of(mesh.triangles)
    crowded = np.flatnonzero((edges.uses > 2) & (edges.uses % 2 == 0) & (edges.net == 0))
    if not 0 < len(crowded) <= MOST_TOUCHING_SHARE * len(edges.uses) or (edges.uses % 2 == 1).any():
        return mesh, {"split_edges": 0}
    apart = _apart(mesh.points, mesh.triangles, edges, crowded)
    fans, fan = corner_fans(mesh.triangles, apart)
    of_fan = np.zeros(fans, dtype=np.int64)
    of_fan[fan.reshape(-1)] = mesh.triangles.reshape(-1)
    ends = np.unique(edges.points[crowded])
    several = ends[np.bincount(of_fan, minlength=len(mesh.points))[ends] > 1]
    split = weld(split_fans(mesh, several, fan))
    left = int((edges_of(split.triangles).uses > 2).sum())
    if left >= len(crowded):
        return mesh, {"split_edges": 0}
    return split, {"split_edges": len(crowded) - left}


def _apart(points: FloatArray, triangles: IntArray, edges: Edges, crowded: IntArray) -> Edges:
    """The edges, with a separate number for every wedge after the first."""
    of_face, count = edges.of_face.copy(), len(edges.uses)
    flat = edges.of_face.reshape(-1)
    halves = np.flatnonzero(np.isin(flat, crowded))
    halves = halves[np.argsort(flat[halves], kind="stable")]
    for around in np.split(halves, np.cumsum(edges.uses[crowded])[:-1]):
        wedges = _wedges(points, triangles, edges.upward.reshape(-1)[around], around)
        for pair in wedges[1:]:
            of_face.reshape(-1)[pair] = count
            count += 1
    uses = np.bincount(of_face.reshape(-1), minlength=count)
    first = np.zeros((count, 2), dtype=np.int64)
    first[: len(edges.points)] = edges.points
    return replace(edges, points=first, of_face=of_face, uses=uses)


def _wedges(points: FloatArray, triangles: IntArray, upward: BoolArray, halves: IntArray) -> list[IntArray]:
    """The half-edges (k,) around one edge as pairs that bound one wedge of solid each; one group when they do not."""
    face, side = halves // 3, halves % 3
    tail, head = triangles[face, side], triangles[face, (side + 1) % 3]
    low = np.where(upward, tail, head)[0]
    axis = points[np.where(upward, head, tail)[0]] - points[low]
    axis = axis / max(float(np.linalg.norm(axis)), np.finfo(float).tiny)
    away = points[triangles[face, (side + 2) % 3]] - points[low]
    away = away - np.outer(away @ axis, axis)
    x = away[0] / max(float(np.linalg.norm(away[0])), np.finfo(float).tiny)
    angle = np.arctan2(away @ np.cross(axis, x), away @ x)
    order = np.argsort(angle, kind="stable")
    turn = np.diff(np.append(angle[order], angle[order][0] + 2 * np.pi))
    ways = upward[order]
    if turn.min() < CONTACT_ANGLE or (ways == np.roll(ways, 1)).any():
        return [halves]
    # Seen along the edge, matter lies after a face that runs down and before the next one, which runs up.
    start = int(np.flatnonzero(~ways)[0])
    ring = halves[np.roll(order, -start)]
    return [*ring.reshape(-1, 2)]
