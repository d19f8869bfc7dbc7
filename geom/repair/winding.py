"""Winding of faces: flips that make closed surfaces face outward and their cavities inward."""

from __future__ import annotations

import numpy as np

from geom.mesh.components import Components, components_of, opposite_container
from geom.mesh.edges import consistent_flips, edges_of
from geom.mesh.edit import flip_faces
from geom.repair.boundary_loops import classify_open_bodies
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.model import Mesh

Figures = dict[str, float]


def orient(mesh: Mesh, fixed: BoolArray | None = None) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) with its solids wound outwards. Figures: `flipped_faces`.

    Components with a face where `fixed` (m,) is True are unchanged.
    """
    flips = outward_flips(mesh.points, mesh.triangles)
    if fixed is not None:
        parts = components_of(mesh.points, mesh.triangles)
        flips &= (np.bincount(parts.label[fixed], minlength=parts.count) == 0)[parts.label]
    return flip_faces(mesh, flips), {"flipped_faces": int(flips.sum())}


def outward_flips(points: FloatArray, triangles: IntArray) -> BoolArray:
    """(m,) True where a face must be flipped.

    First neighbours are made to agree, spreading across edges with two faces, by flipping the minority. Then closed
    components with negative volume are flipped together with their cavities, so that cavities stay inward; so are
    nearly closed ones (class `holes` of `boundary_loops`) whose capped volume is negative. Other open sheets keep their
    winding: they have no outside.
    """
    edges = edges_of(triangles)
    before = components_of(points, triangles, edges)
    flips, _ = consistent_flips(edges)
    flips &= ~before.consistent[before.label]
    turned = _turned(triangles, flips)
    agreed = edges_of(turned)
    parts = components_of(points, turned, agreed)
    volume = np.where(parts.solid, parts.volume, 0.0)
    outward = parts.inside_out
    nearly_closed = np.zeros(parts.count, dtype=bool)
    for body in classify_open_bodies(points, turned, agreed, parts):
        if body.kind == "holes":
            part = parts.label[body.faces[0]]
            nearly_closed[part] = True
            volume[part] = body.capped_volume
            outward[part] = body.capped_volume < 0.0
    parent = opposite_container(points, turned, parts, volume)
    outward &= parent < 0
    for part in np.argsort(-parts.extent, kind="stable"):  # Containers come before what they contain.
        outward[part] |= parent[part] >= 0 and outward[parent[part]]
    keep = _solid_or(parts, nearly_closed)
    return (flips ^ outward[parts.label]) & keep[parts.label]


def _solid_or(parts: Components, nearly_closed: BoolArray) -> BoolArray:
    return (parts.closed & parts.consistent) | nearly_closed


def _turned(triangles: IntArray, flips: BoolArray) -> IntArray:
    return np.where(flips[:, None], triangles[:, [0, 2, 1]], triangles)
