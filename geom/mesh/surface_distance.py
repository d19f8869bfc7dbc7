"""Point samples of triangle surfaces, nearest points on them, and distances between two surfaces, by Open3D.

Surfaces are points (n, 3) and triangles (m, 3); distances are in the unit of the points.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass

import numpy as np

from schemas.arrays import BoolArray, FloatArray, IntArray

# Loaded before Open3D and CoACD, which otherwise clash when CoACD comes first.
importlib.import_module("scipy.spatial")

P95 = 95.0


@dataclass(frozen=True)
class SurfaceDistance:
    """One-sided distances both ways, in the unit of the points (metres after canonicalisation).

    `p95` and `mean` are over area-weighted samples; `max` is over samples and vertices, a lower bound of the one-sided
    Hausdorff distance.
    """

    a_to_b_mean: float
    a_to_b_p95: float
    a_to_b_max: float
    b_to_a_mean: float
    b_to_a_p95: float
    b_to_a_max: float
    samples: int

    @property
    def hausdorff(self) -> float:
        """The larger of the two one-sided maxima."""
        return max(self.a_to_b_max, self.b_to_a_max)


def two_way_distance(
    points_a: FloatArray,
    triangles_a: IntArray,
    points_b: FloatArray,
    triangles_b: IntArray,
    samples: int = 4000,
    seed: int = 0,
) -> SurfaceDistance:
    """Sampled distances between surfaces A and B; equal arguments give equal values.

    Points (n, 3) and triangles (m, 3) of both. Raises ValueError when a surface has no area.
    """
    a_mean, a_p95, a_max = _one_way(points_a, triangles_a, points_b, triangles_b, samples, seed)
    b_mean, b_p95, b_max = _one_way(points_b, triangles_b, points_a, triangles_a, samples, seed)
    return SurfaceDistance(a_mean, a_p95, a_max, b_mean, b_p95, b_max, samples)


def sample_surface(points: FloatArray, triangles: IntArray, samples: int, seed: int) -> tuple[FloatArray, IntArray]:
    """`samples` points (k, 3) uniform over the area, and the triangle (k,) each lies on.

    Stratified along the cumulative area (one draw per equal share), which halves the spread of plain sampling;
    inside a triangle by the square-root map (Osada et al. 2002, "Shape distributions", eq. 1).
    Raises ValueError when the surface has no area.
    """
    corners = points[triangles]
    areas = triangle_areas(corners)
    total = float(areas.sum())
    if not total > 0.0:
        raise ValueError("the surface has no area to sample")
    rng = np.random.default_rng(seed)
    strata = (np.arange(samples) + rng.random(samples)) / samples * total
    index = np.minimum(np.searchsorted(np.cumsum(areas), strata, side="right"), len(areas) - 1)
    root, share = np.sqrt(rng.random(samples)), rng.random(samples)
    weights = np.stack([1.0 - root, root * (1.0 - share), root * share], axis=1)
    return np.einsum("kc,kcx->kx", weights, corners[index]), index


def triangle_areas(corners: FloatArray) -> FloatArray:
    """Areas (m,) of triangles given by their corners (m, 3, 3)."""
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


# Three directions at irregular angles to each other and to the axes.
_RAY_DIRECTIONS = np.array([[0.8413, 0.3571, 0.4057], [-0.4421, 0.7879, 0.4289], [0.2717, -0.5233, -0.8076]])


class NearestOnSurface:
    """Nearest points on one surface for many queries; the search tree over its triangles is built once.

    Exact up to single precision of the surface's extent: it is centred and scaled to unit size first, so its position
    in the world does not matter. Raises ValueError when the surface has no area.
    """

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        import open3d as o3d  # Costs a second and 200 MB: loaded only when distances are needed.

        self._kept = np.flatnonzero(triangle_areas(points[triangles]) > 0.0)  # A zero-area triangle yields NaN.
        if self._kept.size == 0:
            raise ValueError("the surface has no area to measure against")
        used = points[triangles[self._kept]].reshape(-1, 3)
        low, high = used.min(axis=0), used.max(axis=0)
        self._centre, self._scale = 0.5 * (low + high), float(np.max(high - low)) or 1.0
        self._scene = o3d.t.geometry.RaycastingScene()
        self._tensor = o3d.core.Tensor.from_numpy
        self._scene.add_triangles(
            self._tensor(((points - self._centre) / self._scale).astype(np.float32)),
            self._tensor(triangles[self._kept].astype(np.uint32)),
        )

    def __call__(self, queries: FloatArray) -> tuple[FloatArray, IntArray]:
        """For each query (k, 3): the nearest point of the surface (k, 3) and the triangle (k,) it lies on."""
        unit_queries = ((queries - self._centre) / self._scale).astype(np.float32)
        answer = self._scene.compute_closest_points(self._tensor(unit_queries))
        nearest = answer["points"].numpy().astype(np.float64) * self._scale + self._centre
        return nearest, self._kept[answer["primitive_ids"].numpy().astype(np.int64)]

    def inside(self, queries: FloatArray) -> BoolArray:
        """(k,) True for queries (k, 3) inside the surface, which must be closed: majority of three ray parities.

        The three directions differ widely and lie in no plane that is usual in shapes. The occupancy test of Open3D
        casts all three nearly along x, so that all of them run in the plane of the same face.
        """
        odd = np.zeros(len(queries), dtype=np.int64)
        for direction in _RAY_DIRECTIONS:
            rays = np.tile(direction, (len(queries), 2))
            rays[:, :3] = (queries - self._centre) / self._scale
            odd += self._scene.count_intersections(self._tensor(rays.astype(np.float32))).numpy() % 2
        return odd >= 2

    def enclosed_share(self, origin: FloatArray, count: int) -> float:
        """The share of `count` even directions (Fibonacci lattice) whose rays from `origin` (3,) hit the surface."""
        height = 1.0 - (2.0 * np.arange(count) + 1.0) / count
        turn, across = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0)), np.sqrt(1.0 - height**2)
        rays = np.tile((origin - self._centre) / self._scale, (count, 2))
        rays[:, 3:] = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
        hits = self._scene.cast_rays(self._tensor(rays.astype(np.float32)))["t_hit"].numpy()
        return float(np.isfinite(hits).mean())


def closest_on_surface(queries: FloatArray, points: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """`NearestOnSurface` for a single round of queries."""
    return NearestOnSurface(points, triangles)(queries)


class SignedDistance:
    """Signed distance to the surface of one closed body, negative inside; the search tree is built once."""

    def __init__(self, points: FloatArray, triangles: IntArray) -> None:
        """Points (n, 3) and triangles (m, 3) of a closed surface about the origin, of about unit size."""
        import open3d as o3d

        self._tensor = o3d.core.Tensor.from_numpy
        self._scene = o3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(self._tensor(points.astype(np.float32)), self._tensor(triangles.astype(np.uint32)))

    def __call__(self, queries: FloatArray) -> FloatArray:
        """Distances (k,) of queries (k, 3); a point is inside when most of three rays cross an odd number of faces."""
        query_tensor = self._tensor(np.ascontiguousarray(queries, dtype=np.float32))
        return self._scene.compute_signed_distance(query_tensor, nsamples=3).numpy().astype(np.float64)


def _one_way(
    points_a: FloatArray, triangles_a: IntArray, points_b: FloatArray, triangles_b: IntArray, samples: int, seed: int
) -> tuple[float, float, float]:
    """Mean and 95th percentile over samples of A, and the maximum over samples and vertices, against B."""
    samples_a, _ = sample_surface(points_a, triangles_a, samples, seed)
    vertices = points_a[np.unique(triangles_a)]
    queries = np.concatenate([samples_a, vertices])
    nearest, _ = closest_on_surface(queries, points_b, triangles_b)
    distances = np.linalg.norm(queries - nearest, axis=1)
    sampled = distances[:samples]
    return float(sampled.mean()), float(np.percentile(sampled, P95)), float(distances.max())
