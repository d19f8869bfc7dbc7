"""A descriptor of a surface that rotation, uniform scale and tessellation hardly change, and distances of two of them.

Moments are exact integrals over the triangles; quantiles of point distances come from seeded samples (D2 of Osada,
Funkhouser, Chazelle and Dobkin 2002, "Shape distributions").
"""

from __future__ import annotations

import numpy as np

from geom.mesh.surface_distance import sample_surface, triangle_areas
from schemas.arrays import FloatArray, IntArray
from schemas.asset import ShapeDescriptor

PAIRS = 16384  # Of points: the sampling error of a quantile is about 1 / sqrt(PAIRS), 0.8 % of the spread.
QUANTILES = 16  # Enough to separate distributions of different modes; 64 separate no pair of assets that 16 do not.
MOMENTS = 5  # second and third moments, the first figures of a vector
DIGITS = 5  # Stored: finer than the sampling error of quantiles by two orders.

# Rule of degree 3 on a triangle with four points (Strang and Fix 1973): barycentric coordinates and weights.
_BARYCENTRIC = np.array([[1 / 3, 1 / 3, 1 / 3], [0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]])
_WEIGHTS = np.array([-27 / 48, 25 / 48, 25 / 48, 25 / 48])


def shape_descriptor(points: FloatArray, triangles: IntArray, seed: int = 0) -> ShapeDescriptor | None:
    """The descriptor of a surface with points (n, 3) in metres and triangles (m, 3); None when it has no area.

    Equal arguments give equal numbers.
    """
    corners = points[triangles]
    areas = triangle_areas(corners)
    total = float(areas.sum())
    if not total > 0.0:
        return None
    places = np.einsum("qc,mcx->mqx", _BARYCENTRIC, corners).reshape(-1, 3)
    weights = (areas[:, None] * _WEIGHTS / total).reshape(-1)
    places = places - weights @ places
    second = np.einsum("i,ij,ik->jk", weights, places, places)
    scale = float(np.sqrt(np.trace(second)))
    if not scale > 0.0:
        return None
    second, unit = second / scale**2, places / scale
    third = np.einsum("i,ij,ik,il->jkl", weights, unit, unit, unit, optimize=True)
    trace = np.einsum("ijj->i", third)
    return ShapeDescriptor(
        scale_m=scale,
        second_moments=_rounded3(np.linalg.eigvalsh(second)[::-1].astype(np.float64)),
        third_moments=(_rounded(float(np.linalg.norm(third))), _rounded(float(np.linalg.norm(trace)))),
        distances=tuple(_rounded(float(d)) for d in _distance_quantiles(points, triangles, seed) / scale),
    )


def vector_of(shape: ShapeDescriptor) -> FloatArray:
    """(MOMENTS + QUANTILES,) the figures that do not depend on scale: second moments, third moments, quantiles."""
    return np.array([*shape.second_moments, *shape.third_moments, *shape.distances])


def descriptor_distances(vector: FloatArray, others: FloatArray) -> FloatArray:
    """(k,) distances of a vector (`vector_of`) to others (k, MOMENTS + QUANTILES).

    Each is the largest of the differences of moments and of the mean difference of quantiles, which is the Wasserstein
    distance of the two D2 distributions. A mirror image has distance 0 but for sampling.
    """
    off = np.abs(others - vector)
    return np.maximum(off[:, :MOMENTS].max(axis=1), off[:, MOMENTS:].mean(axis=1))


def _distance_quantiles(points: FloatArray, triangles: IntArray, seed: int) -> FloatArray:
    """(QUANTILES,) quantiles of the distance between two points drawn evenly and independently from the surface."""
    samples, _ = sample_surface(points, triangles, 2 * PAIRS, seed)
    # Samples follow the order of the triangles; only shuffled ones are independent of each other.
    order = np.random.default_rng(seed).permutation(2 * PAIRS)
    lengths = np.linalg.norm(samples[order[:PAIRS]] - samples[order[PAIRS:]], axis=1)
    return np.sort(lengths)[(np.arange(2 * QUANTILES)[1::2] * PAIRS) // (2 * QUANTILES)]


def _rounded3(values: FloatArray) -> tuple[float, float, float]:
    a, b, c = (_rounded(float(v)) for v in values)
    return a, b, c


def _rounded(value: float) -> float:
    return round(value, DIGITS) + 0.0  # + 0.0: no negative zero
