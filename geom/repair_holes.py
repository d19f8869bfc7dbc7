"""Fill boundary loops with triangles."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np

from geom.edges import edges_of
from geom.mesh_edit import append_faces
from geom.openings import Opening
from schemas.model import FloatArray, IntArray, Mesh

Figures = dict[str, float]


def fill_openings(mesh: Mesh, openings: Sequence[Opening]) -> tuple[Mesh, Figures]:
    """`mesh` with each loop closed by a cap that continues its winding.

    New corners take UV and colour of the rim corner at the same point. Figures: `holes` filled, `filled_area`.
    """
    points, triangles, filled_area = cap_openings(mesh.points, mesh.triangles, openings)
    new = triangles[len(mesh.triangles) :]
    corner_at: dict[int, int] = {}
    for opening in openings:
        for face in opening.faces:
            for k in range(3):
                corner_at.setdefault(int(mesh.triangles[face, k]), 3 * int(face) + k)
    anchor = [corner_at[int(opening.points[0])] for opening in openings]  # For the one point that a fan may add.
    hub = {len(mesh.points) + i: anchor[i] for i in range(len(anchor))}
    known = {**hub, **corner_at}
    like = np.array([[known[int(v)] for v in face] for face in new], dtype=np.int64).reshape(-1, 3)
    return append_faces(mesh, points, new, like), {"holes": len(openings), "filled_area": filled_area}


def cap_openings(
    points: FloatArray, triangles: IntArray, openings: Sequence[Opening]
) -> tuple[FloatArray, IntArray, float]:
    """Points and triangles with a cap appended for each loop, and the area of the caps.

    A loop is triangulated in its mean plane without new points (ear clipping, manifold3d). Where that would repeat an
    edge the mesh has, or the loop crosses itself in that plane, the cap is a fan about the loop's centroid.
    One point per opening is appended in order; those that no fan uses are left unreferenced.
    """
    if not openings:
        return points, triangles, 0.0
    present = {(int(a), int(b)) for a, b in edges_of(triangles).points}
    caps, hubs = [], []
    for i, opening in enumerate(openings):
        rim = points[opening.points]
        hubs.append(rim.mean(axis=0))
        caps.append(_ears(rim, opening.points, present))
        if caps[-1] is None:
            hub = np.full(len(rim), len(points) + i)
            caps[-1] = np.stack([opening.points, np.roll(opening.points, -1), hub], axis=1)
    grown = np.concatenate([points, hubs])
    new = np.concatenate([cap for cap in caps if cap is not None]).astype(triangles.dtype)
    corners = grown[new]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    return grown, np.concatenate([triangles, new]), float(area)


def _ears(rim: FloatArray, index: IntArray, present: set[tuple[int, int]]) -> IntArray | None:
    """Triangles over the loop's own points, or None when they would not be a clean cap."""
    if len(rim) == 3:
        return index[None]
    centred = rim - rim.mean(axis=0)
    vector_area = 0.5 * np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    area = float(np.linalg.norm(vector_area))
    if area == 0.0:
        return None
    u, v = np.linalg.svd(vector_area[None])[2][1:]
    if np.dot(np.cross(u, v), vector_area) < 0.0:
        v = -v
    flat = np.stack([centred @ u, centred @ v], axis=1)
    local = manifold3d.triangulate([flat])
    a, b, c = flat[local[:, 0]], flat[local[:, 1]], flat[local[:, 2]]
    signed = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    if len(local) != len(rim) - 2 or (signed < -1e-9 * area).any():
        return None
    cap = index[local]
    sides = np.sort(np.stack([cap, np.roll(cap, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    loop = np.sort(np.stack([index, np.roll(index, -1)], axis=1), axis=1)
    rim_edges = {(int(p), int(q)) for p, q in loop}
    if any((int(p), int(q)) in present and (int(p), int(q)) not in rim_edges for p, q in sides):
        return None
    return cap
