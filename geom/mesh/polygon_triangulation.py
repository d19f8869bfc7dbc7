"""Triangulation of polygons in space, with or without holes: fans where convex, else ear clipping (manifold3d)."""

from __future__ import annotations

import manifold3d
import numpy as np

from schemas.arrays import IntArray


def triangulate_polygons(points: np.ndarray, corners: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of polygons given as runs of corners.

    points   (n, 3) float64; corners (c,) indices into points; counts (f,) corners per polygon, each >= 3, sum c.
    Returns  (m, 3) int64 positions *in `corners`*, so that any per-corner attribute can follow, and (m,) int64 the
             polygon of each triangle, in polygon order. A polygon of k corners gives k - 2 triangles, same winding.

    Convex polygons become fans. Others, such as L-shapes and holes joined by a bridge edge, are projected along
    their Newell normal and cut by ear clipping (`manifold3d.triangulate`, which tolerates touching edges).
    """
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64) if len(counts) else np.zeros(0, np.int64)
    triangles: list[np.ndarray] = []
    owners: list[np.ndarray] = []
    for k in np.unique(counts):
        faces = np.flatnonzero(counts == k)
        rings: IntArray = starts[faces, None] + np.arange(int(k))
        convex = np.ones(len(faces), dtype=bool) if k == 3 else _convex(points[corners[rings]])
        fan = np.stack([np.zeros(k - 2, np.int64), np.arange(1, k - 1), np.arange(2, k)], axis=1)
        triangles.append(rings[convex][:, fan].reshape(-1, 3))
        owners.append(np.repeat(faces[convex], k - 2))
        for face, ring in zip(faces[~convex], rings[~convex], strict=True):
            cut = _ear_clip(points[corners[ring]])
            triangles.append(ring[fan if cut is None else cut])
            owners.append(np.full(k - 2, face))
    if not triangles:
        return np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(triangles)[order], owner[order]


def newell_normals(rings: np.ndarray) -> np.ndarray:
    """(f, 3) area-weighted normals (twice the vector area) of (f, k, 3) polygons, after Newell."""
    centred = rings - rings.mean(axis=1, keepdims=True)
    return np.cross(centred, np.roll(centred, -1, axis=1)).sum(axis=1)


def _convex(rings: np.ndarray) -> np.ndarray:
    """(f,) True where every corner of the (f, k, 3) polygons turns the same way and the ring winds once."""
    normals = newell_normals(rings)
    edges = np.roll(rings, -1, axis=1) - rings
    turns = np.einsum("fki,fi->fk", np.cross(np.roll(edges, 1, axis=1), edges), normals)
    scale = np.einsum("fi,fi->f", normals, normals)
    # A fan from corner 0 must not fold either: that also excludes rings that wind round twice.
    spokes = rings[:, 1:] - rings[:, :1]
    sweeps = np.einsum("fki,fi->fk", np.cross(spokes[:, :-1], spokes[:, 1:]), normals)
    tolerance = -1e-9 * scale[:, None]
    return np.asarray((turns >= tolerance).all(axis=1) & (sweeps >= tolerance).all(axis=1))


def _ear_clip(ring: np.ndarray) -> np.ndarray | None:
    """(k - 2, 3) triangles of one (k, 3) polygon, or None where it has no area to project on."""
    axes = _plane(ring)
    if axes is None:
        return None
    flat = (ring - ring.mean(axis=0)) @ axes
    cut = np.asarray(manifold3d.triangulate([flat / np.abs(flat).max()]), dtype=np.int64).reshape(-1, 3)
    return cut if len(cut) == len(ring) - 2 else None


def triangulate_with_holes(rings: list[np.ndarray]) -> np.ndarray:
    """(m, 3) int64 triangles of one polygon with holes, as positions in the rings laid end to end.

    rings  (k_i, 3) float64 each: the outline first, then the holes, in any direction. The triangles are wound as the
    outline is. Without area to project on, the outline alone becomes a fan.
    """
    axes = _plane(rings[0])
    if axes is None:
        k = len(rings[0])
        return np.stack([np.zeros(k - 2, np.int64), np.arange(1, k - 1), np.arange(2, k)], axis=1)
    origin = rings[0].mean(axis=0)
    flat = [(r - origin) @ axes for r in rings]
    scale = max(float(np.abs(f).max()) for f in flat)
    starts: list[int] = np.cumsum([0, *(len(f) for f in flat[:-1])]).tolist()
    # The triangulator needs the outline counter-clockwise and holes clockwise: reverse the others.
    position: list[IntArray] = [
        np.arange(start, start + len(f)) if (_area(f) > 0) == (i == 0) else np.arange(start + len(f) - 1, start - 1, -1)
        for i, (start, f) in enumerate(zip(starts, flat, strict=True))
    ]
    order = np.concatenate(position)
    laid = np.concatenate(flat)
    cut = manifold3d.triangulate([laid[p] / scale for p in position])
    return order[np.asarray(cut, dtype=np.int64).reshape(-1, 3)]


def _area(ring: np.ndarray) -> float:
    x, y = ring[:, 0], ring[:, 1]
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2


def _plane(ring: np.ndarray) -> np.ndarray | None:
    """(3, 2) axes of the plane a (k, 3) ring lies in, the ring counter-clockwise in them; None without area."""
    normal = newell_normals(ring[None])[0]
    length = float(np.linalg.norm(normal))
    if not np.isfinite(length) or length == 0.0:
        return None
    normal = normal / length
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)], axis=1)
