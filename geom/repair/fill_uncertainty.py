"""Uncertainty of a filled hole: how far the missing surface may lie from the cap, in the unit of the points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from geom.mesh.edges import edges_of
from geom.mesh.loop_triangulation import continued_faces, unit_normals
from geom.mesh.surface_distance import triangle_areas
from geom.repair.boundary_loops import Opening
from schemas.arrays import FloatArray, IntArray

# A face steeper than this against the cap is a side of the design and no evidence about the missing piece.
STEEP_COSINE = 0.5
# A cap of so few triangles, not much larger than the largest face beyond the rim, may be the original surface.
FEW_TRIANGLES, SAME_SIZE = 8, 1.33
SHARP_BEND_RAD, MINUTE_RAD = float(np.radians(60.0)), float(np.radians(0.5))
# Flat sides are sought in caps of up to this many triangles; more are a curved surface.
MOST_SIDES = 60
CLEARLY_FLAT = 0.25
_TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class ShapeUncertainty:
    """A possible deviation of a repaired shape: its length and the point `at` (3,), in the unit of the points."""

    length: float
    at: FloatArray


def fill_uncertainty(
    points: FloatArray, triangles: IntArray, opening: Opening, cap: IntArray, around: IntArray
) -> ShapeUncertainty:
    """How far the `cap` (k, 3) of an opening of the surface may lie from the piece that is missing.

    `around` (f, 3) are the faces near the rim. A cap of one triangle is exact, and so is a small one that looks like
    its neighbourhood (`_looks_alike`): no point of the surface is missing there. Otherwise the missing piece is
    modelled as smooth (`_off_quadric`), or as flat sides that meet at edges (`_off_planes`) where these fit the cap
    four times better. The uncertainty is the largest distance between model and cap, at the middles of the cap's
    triangles and edges.
    """
    corners, beyond = points[cap], points[triangles[opening.faces]]
    centre = points[opening.points].mean(axis=0)
    if len(cap) == 1 or (len(cap) <= FEW_TRIANGLES and _looks_alike(points, beyond, opening, cap, around)):
        return ShapeUncertainty(0.0, centre)
    inside = np.concatenate([corners.mean(axis=1), *(0.5 * (corners[:, k] + corners[:, k - 1]) for k in range(3))])
    off = _off_quadric(points, beyond, opening, inside)
    if len(cap) <= MOST_SIDES:
        flat = _off_planes(points, beyond, opening, cap, inside)
        off = flat if flat.max() < CLEARLY_FLAT * off.max() else off
    return ShapeUncertainty(float(off.max()), inside[off.argmax()])


def _looks_alike(points: FloatArray, beyond: FloatArray, opening: Opening, cap: IntArray, around: IntArray) -> bool:
    """True iff the triangles of the cap are as large as the faces beyond and bend no more than these among each other.

    Bends of 60 degrees and more are edges of the design and no measure.
    """
    if triangle_areas(points[cap]).mean() > SAME_SIZE * triangle_areas(beyond).max():
        return False
    edges, normals = edges_of(around), unit_normals(points[around])
    pairs = np.argsort(edges.of_face.reshape(-1), kind="stable")
    first = (np.cumsum(edges.uses) - edges.uses)[edges.uses == 2]
    cosines = np.einsum("ij,ij->i", normals[pairs[first] // 3], normals[pairs[first + 1] // 3])
    bends = np.arccos(np.clip(cosines, -1.0, 1.0))
    most = bends[bends < SHARP_BEND_RAD].max(initial=0.0)
    return bool(continued_faces(points, unit_normals(beyond), opening.points, cap)[1].max() <= 1.1 * most + MINUTE_RAD)


def _off_planes(
    points: FloatArray, beyond: FloatArray, opening: Opening, cap: IntArray, inside: FloatArray
) -> FloatArray:
    """Distances of points (4 k, 3) of the cap from the planes of the faces beyond the rim that it continues.

    Each triangle of the cap continues the plane of the face from which it bends least, directly or through others.
    """
    normals = unit_normals(beyond)
    source_face, _ = continued_faces(points, normals, opening.points, cap)
    source_face = np.tile(source_face, 4)
    return np.abs(np.einsum("ij,ij->i", inside - beyond[source_face, 0], normals[source_face]))


def _off_quadric(points: FloatArray, beyond: FloatArray, opening: Opening, inside: FloatArray) -> FloatArray:
    """Heights of points (k, 3) of the cap over a smooth model of the missing piece.

    Over the rim's mean plane: a quadric fitted to the rim and to the slopes of the faces beyond it (least squares,
    sides weighted by length), plus its residual at the rim, interpolated inwards with the inverse squared distance.
    """
    centre = points[opening.points].mean(axis=0)
    frame = _loop_frame(points[opening.points] - centre)
    size = float(np.linalg.norm(points[opening.points] - centre, axis=1).max())
    rim = (points[opening.points] - centre) @ frame.T / size
    quadric = _fitted_quadric(rim, unit_normals(beyond) @ frame.T)
    local = (inside - centre) @ frame.T / size
    residual = rim[:, 2] - _terms(rim) @ quadric
    closeness = 1.0 / np.maximum(((local[:, None] - rim) ** 2).sum(axis=2), 1e-12)
    model = _terms(local) @ quadric + (closeness @ residual) / closeness.sum(axis=1)
    return size * np.abs(model - local[:, 2])


def _fitted_quadric(rim: FloatArray, normals: FloatArray) -> FloatArray:
    """(6,) coefficients of the quadric that best fits heights of the rim's sides and the slopes beyond them."""
    ahead = np.roll(rim, -1, axis=0)
    middle, length = 0.5 * (rim + ahead), np.linalg.norm(ahead - rim, axis=1)
    sloped = normals[:, 2] > STEEP_COSINE
    u, v = middle[sloped, 0], middle[sloped, 1]
    zero, ones = np.zeros(len(u)), np.ones(len(u))
    slopes = -normals[sloped, :2] / normals[sloped, 2:]
    rows = [
        _terms(middle),
        np.stack([zero, ones, zero, 2 * u, v, zero], axis=1),
        np.stack([zero, zero, ones, zero, u, 2 * v], axis=1),
    ]
    known = np.concatenate([middle[:, 2], slopes[:, 0], slopes[:, 1]])
    weight = np.sqrt(np.concatenate([length, length[sloped], length[sloped]]) / length.sum())
    system = np.concatenate(rows) * weight[:, None]
    return cast(FloatArray, np.linalg.lstsq(system, known * weight, rcond=None)[0])


def _terms(at: FloatArray) -> FloatArray:
    """(k, 6) the terms of a quadric over a plane."""
    u, v = at[:, 0], at[:, 1]
    return np.stack([np.ones(len(u)), u, v, u * u, u * v, v * v], axis=1)


def _loop_frame(rim: FloatArray) -> FloatArray:
    """(3, 3) rows x, y, z of a right-handed frame whose z is the direction of the loop's vector area."""
    vector_area = np.cross(rim, np.roll(rim, -1, axis=0)).sum(axis=0)
    x, y = np.linalg.svd(vector_area[None])[2][1:]
    z = vector_area / max(float(np.linalg.norm(vector_area)), _TINY)
    return np.stack([x, y if np.cross(x, y) @ z > 0.0 else -y, z])
