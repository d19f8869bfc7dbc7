"""Places of a source surface that belong to places of a light one: by rays along its smooth normals, else the nearest.

From each place one ray goes outward and one inward; the nearer hit counts whose face looks the same way. Where neither
hits within reach, the nearest place of the source is taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geom.mesh.corner_normals import face_normals
from geom.mesh.rays import RayHits, Rays
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

REACH_FACTOR = 1.5  # of the largest distance between the surfaces: rays are oblique to the shortest way
_START_SHARE = 1e-5  # of the extent: how far before its place a ray starts, tens of roundings of single precision


class Projected(NamedTuple):
    """Places of the source: triangles (k,), (k, 3) barycentric weights; which of them were hit by a ray (k,)."""

    faces: IntArray
    weights: FloatArray
    by_ray: FloatArray


class Projector:
    """Projects places onto the surface of one mesh; the search tree is built once."""

    def __init__(self, source: Mesh) -> None:
        self._rays = Rays(source.points, source.triangles)
        self._normals = face_normals(source.points, source.triangles).astype(np.float64)
        self._start = _START_SHARE * float(np.ptp(source.points, axis=0).max())

    def reach_to(self, points: FloatArray) -> float:
        """How far rays from a surface may go that passes through `points` (k, 3)."""
        return REACH_FACTOR * float(self._rays.nearest(points)[2].max()) + 2.0 * self._start

    def __call__(self, places: FloatArray, directions: FloatArray, reach: float) -> Projected:
        """The places of the source that belong to `places` (k, 3) with outward unit `directions` (k, 3)."""
        ahead = self._rays.hits(places - self._start * directions, directions)
        behind = self._rays.hits(places + self._start * directions, -directions)
        away = [self._usable(hits, directions, reach) for hits in (ahead, behind)]
        inward = away[1] < away[0]
        faces = np.where(inward, behind.triangles, ahead.triangles)
        weights = np.where(inward[:, None], behind.weights, ahead.weights)
        missed = np.flatnonzero(~np.isfinite(np.minimum(*away)))
        if len(missed):
            faces[missed], weights[missed], _ = self._rays.nearest(places[missed])
        by_ray = np.ones(len(places))
        by_ray[missed] = 0.0
        return Projected(faces, weights, by_ray)

    def _usable(self, hits: RayHits, directions: FloatArray, reach: float) -> FloatArray:
        """Distances (k,) from the places of the hits, inf where one is too far or looks another way."""
        away = np.abs(hits.distances - self._start)
        same_way = np.einsum("ki,ki->k", self._normals[hits.triangles], directions) > 0.0
        return np.where((away <= reach) & same_way & (hits.triangles >= 0), away, np.inf)
