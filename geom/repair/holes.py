"""Hole filling: caps of triangles over the boundary loops of a `Mesh`, with corner attributes and uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import manifold3d
import numpy as np
from scipy.sparse import csr_array

from geom.mesh.corner_normals import corner_normals
from geom.mesh.edges import edges_of
from geom.mesh.edit import append_faces
from geom.mesh.fair_patch import fair_patch
from geom.mesh.loop_triangulation import MOST_POINTS, triangulate_loop, unit_normals
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import diagonal
from geom.repair.boundary_loops import OpenBody, Opening
from geom.repair.fill_uncertainty import ShapeUncertainty, fill_uncertainty
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

Figures = dict[str, float]
# A cap that may be off by more than this share of the diagonal is bent to continue the surface, where that helps.
FLAT_ENOUGH = 2.5e-3


def fill_openings(mesh: Mesh, openings: Sequence[Opening]) -> tuple[Mesh, Figures, tuple[ShapeUncertainty, ...]]:
    """`mesh` with each loop closed by a cap of the same winding, the counts, and the uncertainty of each cap.

    A cap of large uncertainty (`fill_uncertainty`) becomes a smooth patch (`fair_patch`) if that lessens it. Corners on
    the rim take UV and colour of the rim's faces, new ones a mean of these, weighted with the inverse squared distance.
    Figures: `holes` filled, `filled_area`.
    """
    points, flat = triangulate_caps(mesh.points, mesh.triangles, openings)
    bound = FLAT_ENOUGH * diagonal(mesh.points)
    near = _touching(mesh.triangles, np.concatenate([[-1], *(o.points for o in openings)]))
    wide = _touching(mesh.triangles, near)
    caps: list[IntArray] = []
    uncertainties: list[ShapeUncertainty] = []
    bent: list[bool] = []
    for opening, cap in zip(openings, flat, strict=True):
        around = _touching(near, opening.points)
        neighbours = _touching(wide, around)
        uncertainty, added = fill_uncertainty(points, mesh.triangles, opening, cap, neighbours), np.zeros((0, 3))
        if uncertainty.length > bound:
            new, patch = fair_patch(points, around, cap)
            better = fill_uncertainty(np.concatenate([points, new]), mesh.triangles, opening, patch, neighbours)
            if better.length < uncertainty.length:
                uncertainty, cap, added = better, patch, new
        points = np.concatenate([points, added])
        caps.append(cap)
        uncertainties.append(uncertainty)
        bent.append(len(added) > 0)
    new = np.concatenate([*caps, np.zeros((0, 3), dtype=np.int64)])
    filled = append_faces(mesh, points, new, _attribute_mix(mesh, points, openings, caps))
    figures: Figures = {"holes": len(openings), "filled_area": float(triangle_areas(points[new]).sum())}
    smooth = np.repeat(bent, [len(cap) for cap in caps]) if caps else np.zeros(0, dtype=bool)
    return (
        _with_smooth_patches(filled, near, len(mesh.triangles) + np.flatnonzero(smooth)),
        figures,
        tuple(uncertainties),
    )


def _touching(triangles: IntArray, points: IntArray) -> IntArray:
    """Those of `triangles` (m, 3) that have one of `points` as a corner."""
    return triangles[np.isin(triangles, points).any(axis=1)]


def _attribute_mix(mesh: Mesh, points: FloatArray, openings: Sequence[Opening], caps: Sequence[IntArray]) -> csr_array:
    """(3 k, 3 m) weights of the old corners in each corner of the caps."""
    data: list[FloatArray] = []
    columns: list[IntArray] = []
    lengths: list[int] = []
    for opening, cap in zip(openings, caps, strict=True):
        at = mesh.triangles[opening.faces] == opening.points[:, None]  # Each rim point is a corner of the face there.
        corner = 3 * opening.faces + at.argmax(axis=1)
        rim = points[opening.points]
        rim_index = np.searchsorted(opening.points, cap.reshape(-1), sorter=(order := np.argsort(opening.points)))
        rim_index = order[np.minimum(rim_index, len(order) - 1)]
        on_rim = opening.points[rim_index] == cap.reshape(-1)
        for vertex, index, sits in zip(cap.reshape(-1), rim_index, on_rim, strict=True):
            weights = np.array([1.0]) if sits else 1.0 / ((points[vertex] - rim) ** 2).sum(axis=1)
            data.append(weights / weights.sum())
            columns.append(corner[[index]] if sits else corner)
            lengths.append(len(weights))
    shape = (len(lengths), 3 * len(mesh.triangles))
    if not lengths:
        return csr_array(shape)
    return csr_array((np.concatenate(data), np.concatenate(columns), np.cumsum([0, *lengths])), shape=shape)


def _with_smooth_patches(mesh: Mesh, near: IntArray, faces: IntArray) -> Mesh:
    """`mesh` whose `faces` have normals that run smoothly into those `near` the holes, if it has normals."""
    if mesh.normals is None or len(faces) == 0:
        return mesh
    normals = mesh.normals.copy()
    normals[faces] = corner_normals(mesh.points, np.concatenate([mesh.triangles[faces], near]))[: len(faces)]
    return replace(mesh, normals=normals)


def capped_body(points: FloatArray, triangles: IntArray, body: OpenBody) -> tuple[FloatArray, IntArray]:
    """The faces of one `body` of a surface and a cap for each loop (`triangulate_caps`); some points may be unused.

    `body.faces` index the whole surface; the returned triangles (k, 3) index the returned points.
    """
    faces = triangles[body.faces]
    openings = [replace(o, faces=np.searchsorted(body.faces, o.faces)) for o in body.openings]
    points, caps = triangulate_caps(points, faces, openings)
    return points, np.concatenate([faces, *caps]).astype(triangles.dtype)


def triangulate_caps(
    points: FloatArray, triangles: IntArray, openings: Sequence[Opening]
) -> tuple[FloatArray, tuple[IntArray, ...]]:
    """Points and one cap (k, 3) for each loop; `openings` index the points and faces of this surface.

    A loop of at most 150 points is triangulated in space with the least bending (`loop_triangulation`), a longer one in
    its mean plane (ear clipping, manifold3d), neither with new points. Where that would repeat an edge the mesh has, or
    the loop crosses itself in that plane, the cap is a fan about the loop's centroid. One point per opening is appended
    in order; those that no fan uses are left unreferenced.
    """
    if not openings:
        return points, ()
    base = len(points)
    present = edges_of(triangles).points @ np.array([base, 1])  # Sorted, because the edges are.
    caps: list[IntArray] = []
    for i, opening in enumerate(openings):
        index = opening.points.astype(np.int64)
        rim, taken = points[index], _taken_chords(index, base, present)
        local = (
            triangulate_loop(rim, unit_normals(points[triangles[opening.faces]]), taken)
            if len(rim) <= MOST_POINTS
            else _ears(rim, taken)
        )
        caps.append(_fan(index, base + i) if local is None else index[local])
    keys, uses = np.unique(np.concatenate([_edge_keys(cap, base) for cap in caps]), return_counts=True)
    clash = keys[uses > 2]  # Two loops that share two points may both have joined them.
    caps = [
        _fan(opening.points.astype(np.int64), base + i) if np.isin(_edge_keys(cap, base), clash).any() else cap
        for i, (opening, cap) in enumerate(zip(openings, caps, strict=True))
    ]
    hubs = np.array([points[opening.points].mean(axis=0) for opening in openings])
    return np.concatenate([points, hubs]), tuple(caps)


def _fan(loop: IntArray, hub: int) -> IntArray:
    return np.stack([loop, np.roll(loop, -1), np.full(len(loop), hub)], axis=1)


def _edge_keys(triangles: IntArray, base: int) -> IntArray:
    ahead = np.roll(triangles, -1, axis=1)
    return (np.minimum(triangles, ahead) * base + np.maximum(triangles, ahead)).reshape(-1)


def _taken_chords(index: IntArray, base: int, present: IntArray) -> FloatArray:
    """(n, n) True for pairs of loop points that are joined by an edge already; neighbours in the loop do not count."""
    keys = np.minimum.outer(index, index) * base + np.maximum.outer(index, index)
    taken = present[np.minimum(np.searchsorted(present, keys), len(present) - 1)] == keys
    here = np.arange(len(index))
    ahead = np.roll(here, -1)
    taken[here, ahead] = taken[ahead, here] = taken[here, here] = False
    return taken


def _ears(rim: FloatArray, taken: FloatArray) -> IntArray | None:
    """(n - 2, 3) triangles over the loop's own points in its mean plane, or None when they would be no clean cap."""
    centred = rim - rim.mean(axis=0)
    vector_area = 0.5 * np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    area = float(np.linalg.norm(vector_area))
    if area == 0.0:
        return None
    u, v = np.linalg.svd(vector_area[None])[2][1:]
    if np.dot(np.cross(u, v), vector_area) < 0.0:
        v = -v
    flat = np.stack([centred @ u, centred @ v], axis=1)
    cap = manifold3d.triangulate([flat])
    a, b, c = flat[cap[:, 0]], flat[cap[:, 1]], flat[cap[:, 2]]
    signed = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    if len(cap) != len(rim) - 2 or (signed < -1e-9 * area).any() or taken[cap, np.roll(cap, -1, axis=1)].any():
        return None
    return cap
