"""Ray casting: where rays first hit a triangle surface, and how far away (Open3D, single precision)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import Float32Array, FloatArray, IntArray


class RayHits(NamedTuple):
    """First hits of k rays: distances (k,), inf without one; triangles (k,), then -1; (k, 3) barycentric weights."""

    distances: FloatArray
    triangles: IntArray
    weights: FloatArray


class Rays:
    """A surface against which many rays are cast; the search tree over its triangles is built once.

    Accurate to single precision of the surface's extent: it is centred and scaled to unit size first.
    """

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        """Points (n, 3) and triangles (m, 3), at least one of them with area."""
        import open3d as o3d  # Costs a second and 200 MB: loaded only when rays are cast.

        self._kept = np.flatnonzero(triangle_areas(points[triangles]) > 0.0)
        with_area = triangles[self._kept]
        used = points[with_area].reshape(-1, 3)
        low, high = used.min(axis=0), used.max(axis=0)
        self._centre, self._scale = 0.5 * (low + high), float((high - low).max()) or 1.0
        self._tensor = o3d.core.Tensor.from_numpy
        self._scene = o3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(
            self._tensor(((points - self._centre) / self._scale).astype(np.float32)),
            self._tensor(np.ascontiguousarray(with_area.astype(np.uint32))),
        )

    def hit_distances(self, starts: FloatArray, directions: FloatArray) -> FloatArray:
        """Lengths (k,) of rays from `starts` (k, 3) along unit `directions` (k, 3) or (3,) to the first hit, or inf."""
        hits = self._scene.cast_rays(self._tensor(self._unit_rays(starts, directions)))
        return hits["t_hit"].numpy().astype(np.float64) * self._scale

    def hits(self, starts: FloatArray, directions: FloatArray) -> RayHits:
        """The first hits of rays from `starts` (k, 3) along unit `directions` (k, 3) or (3,)."""
        hits = self._scene.cast_rays(self._tensor(self._unit_rays(starts, directions)))
        distances = hits["t_hit"].numpy().astype(np.float64) * self._scale
        missed = ~np.isfinite(distances)
        index = np.where(missed, 0, hits["primitive_ids"].numpy().astype(np.int64))
        second, third = hits["primitive_uvs"].numpy().astype(np.float64).T
        weights = np.stack([1.0 - second - third, second, third], axis=1)
        return RayHits(distances, np.where(missed, -1, self._kept[index]), weights)

    def nearest(self, queries: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """The triangles (k,) nearest to `queries` (k, 3), barycentric weights (k, 3) of the nearest points on them,
        and their distances (k,).
        """
        unit = ((queries - self._centre) / self._scale).astype(np.float32)
        answer = self._scene.compute_closest_points(self._tensor(unit))
        second, third = answer["primitive_uvs"].numpy().astype(np.float64).T
        away = np.linalg.norm(answer["points"].numpy().astype(np.float64) - unit, axis=1) * self._scale
        weights = np.stack([1.0 - second - third, second, third], axis=1)
        return self._kept[answer["primitive_ids"].numpy().astype(np.int64)], weights, away

    def _unit_rays(self, starts: FloatArray, directions: FloatArray) -> Float32Array:
        """(k, 6) rays in the frame of the search tree; directions stay unit, so lengths scale alike."""
        unit = (starts - self._centre) / self._scale
        return np.concatenate([unit, np.broadcast_to(directions, unit.shape)], axis=1).astype(np.float32)
