"""Places of a source surface that belong to places of a light one: by rays along its smooth normals, else the nearest.

From each place one ray goes outward and one inward, through faces that look another way (the far sides of thin walls);
the nearer hit counts. Where neither hits within reach, the nearest place of the source is taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geom.mesh.corner_normals import face_normals
from geom.mesh.rays import RayHits, Rays
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

REACH_FACTOR = 1.5  # of the largest distance between the surfaces: rays are oblique to the shortest way
_MOST_FACES_PASSED = 3
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
        ahead, behind = (self._first_alike(places, directions, side, reach) for side in (1.0, -1.0))
        inward = behind.distances < ahead.distances
        faces = np.where(inward, behind.triangles, ahead.triangles)
        weights = np.where(inward[:, None], behind.weights, ahead.weights)
        missed = np.flatnonzero(~np.isfinite(np.minimum(ahead.distances, behind.distances)))
        if len(missed):
            faces[missed], weights[missed], _ = self._rays.nearest(places[missed])
        by_ray = np.ones(len(places))
        by_ray[missed] = 0.0
        return Projected(faces, weights, by_ray)

    def _first_alike(self, places: FloatArray, directions: FloatArray, side: float, reach: float) -> RayHits:
        """The first hits along `side` times the directions of faces that look as the directions do; inf beyond reach.

        Distances are from the places; a ray goes on behind each face that looks another way.
        """
        distances = np.full(len(places), np.inf)
        triangles, weights = np.full(len(places), -1, dtype=np.int64), np.zeros((len(places), 3))
        travelled = np.full(len(places), -self._start)
        left = np.arange(len(places))
        for _ in range(_MOST_FACES_PASSED + 1):
            ways = side * directions[left]
            hits = self._rays.hits(places[left] + travelled[left, None] * ways, ways)
            away = np.abs(travelled[left] + hits.distances)
            within = np.isfinite(away) & (away <= reach)
            alike = within & (np.einsum("ki,ki->k", self._normals[hits.triangles], directions[left]) > 0.0)
            met = left[alike]
            distances[met], triangles[met], weights[met] = away[alike], hits.triangles[alike], hits.weights[alike]
            passed = within & ~alike
            travelled[left[passed]] += hits.distances[passed] + self._start
            left = left[passed]
            if not len(left):
                break
        return RayHits(distances, triangles, weights)
