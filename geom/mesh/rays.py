"""Ray casting: the distance along rays to the first hit of a triangle surface (Open3D, single precision)."""

from __future__ import annotations

import numpy as np

from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import FloatArray, IntArray


class Rays:
    """A surface against which many rays are cast; the search tree over its triangles is built once.

    Accurate to single precision of the surface's extent: it is centred and scaled to unit size first.
    """

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        """Points (n, 3) and triangles (m, 3), at least one of them with area."""
        import open3d as o3d  # Costs a second and 200 MB: loaded only when rays are cast.

        with_area = triangles[triangle_areas(points[triangles]) > 0.0]
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
        unit = (starts - self._centre) / self._scale
        rays = np.concatenate([unit, np.broadcast_to(directions, unit.shape)], axis=1).astype(np.float32)
        return self._scene.cast_rays(self._tensor(rays))["t_hit"].numpy().astype(np.float64) * self._scale
