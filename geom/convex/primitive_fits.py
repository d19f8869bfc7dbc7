"""Fits of a box, sphere, cylinder and capsule to the convex hull of points; None when a shape does not apply.

All functions take points (n, 3) in metres and return a `CollisionShape` posed in the frame of the points. The quality
of a fit is measured elsewhere (`geom.decomposition.fidelity`).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, cast

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError

from geom.convex.hull import centroid, convex_hull
from geom.mass.inertia import enclosed_volume
from geom.mass.principal_axes import principal_axes
from geom.pose import matrix_of, pose, rotation_to_z
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

# An axis-aligned box is preferred up to this ratio of volumes to the smallest box: its frame has a meaning.
ALIGNED_PREFERENCE = 1.02
# The outline of a projection is resampled to this many points, so that dense corners do not weigh more.
OUTLINE_SAMPLES = 180
# Thinner than this share of their spread, points have only rounding as thickness.
FLAT_ROUNDING_SHARE = 1e-7


def fit_box(points: FloatArray) -> CollisionShape | None:
    """The axis-aligned bounding box, or the smallest oriented one when that is more than 2 % smaller; None when flat.

    Oriented: one face flush with a hull face (`trimesh.bounds.oriented_bounds`; O'Rourke 1985 shows that the exact
    optimum may be slightly smaller). The last few answers are remembered by the bytes of the points: shape, way up and
    colliders of an object ask for the same box.
    """
    return _fitted_box(np.ascontiguousarray(points, dtype=np.float64).tobytes())


@lru_cache(maxsize=4)
def _fitted_box(coordinates: bytes) -> CollisionShape | None:
    points = np.frombuffer(coordinates).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    size = high - low
    centre = 0.5 * (low + high)
    scale = float(size.max())
    across = np.linalg.svd((points - centre) / max(scale, 1e-300), compute_uv=False)
    if not across[-1] > FLAT_ROUNDING_SHARE * across[0]:  # The thickness of a rotated plane is rounding.
        return None
    to_box, oriented = cast(Any, trimesh.bounds).oriented_bounds((points - centre) / scale, ordered=False)
    if np.prod(size / scale) <= ALIGNED_PREFERENCE * np.prod(oriented):
        return CollisionShape("box", _floats(size), pose(None, centre))
    X_AB = np.asarray(np.linalg.inv(to_box), dtype=np.float64)
    X_AB[:3, 3] = X_AB[:3, 3] * scale + centre
    return CollisionShape("box", _floats(oriented * scale), X_AB)


def fit_sphere(points: FloatArray) -> CollisionShape | None:
    """The sphere through the hull's points by algebraic least squares; None when they span no volume.

    Solves `2 c.x + (r² - c.c) = x.x` (Coope 1993, "Circle fitting by linear and nonlinear least squares").
    """
    try:
        corners, _ = convex_hull(points)
    except ValueError:
        return None
    centre, radius = _fit_ball(corners)
    return CollisionShape("sphere", (radius,), pose(None, centre)) if radius > 0.0 else None


def fit_cylinder(points: FloatArray) -> CollisionShape | None:
    """The smallest of the cylinders along the candidate axes, each as long as the points, its circle fitted to the
    outline seen along the axis; None when the points span no volume.
    """
    best: CollisionShape | None = None
    for R_AC, centre, radius, height in _tubes(points):
        if best is None or radius**2 * height < (1.0 - 1e-6) * best.size_m[0] ** 2 * best.size_m[1]:
            best = CollisionShape("cylinder", (radius, height), pose(R_AC, centre))
    return best


def fit_capsule(points: FloatArray) -> CollisionShape | None:
    """The smallest of the capsules along the candidate axes; None when none is longer than its width."""
    best, least = None, np.inf
    for R_AC, centre, radius, height in _tubes(points):
        tube = height - 2.0 * radius
        volume = np.pi * radius**2 * (tube + 4.0 / 3.0 * radius)
        if tube > 0.0 and volume < (1.0 - 1e-6) * least:
            best, least = CollisionShape("capsule", (radius, tube), pose(R_AC, centre)), volume
    return best


def _tubes(points: FloatArray) -> Iterator[tuple[FloatArray, FloatArray, float, float]]:
    """(R_AC, centre, radius, length) per candidate axis: coordinate axes first, then those of inertia.

    z of C is the axis. A body of revolution has its axis among its principal ones; coordinate axes come first because
    assets are mostly modelled along them and a scan's principal axes are noisy.
    """
    try:
        corners, triangles = convex_hull(points)
    except ValueError:
        return
    _, quat_wxyz = principal_axes(enclosed_volume(corners, triangles).second_moment_m5)
    middle = centroid(corners, triangles)
    for axis in (*np.eye(3), *matrix_of(quat_wxyz).T):
        R_AC = rotation_to_z(axis).T
        local = (corners - middle) @ R_AC
        try:
            outline = _resampled(local[ConvexHull(local[:, :2]).vertices, :2])
        except QhullError:
            continue  # The projection along this axis is a line.
        circle, radius = _fit_ball(outline)
        low, high = local[:, 2].min(), local[:, 2].max()
        if radius > 0.0:
            yield R_AC, middle + R_AC @ np.array([*circle, 0.5 * (low + high)]), radius, float(high - low)


def _fit_ball(points: FloatArray) -> tuple[FloatArray, float]:
    """Centre (d,) and radius of the circle or sphere closest to points (n, d) in the algebraic sense; 0 if none."""
    middle = points.mean(axis=0)
    x = points - middle
    scale = float(np.abs(x).max())
    system = np.column_stack([2.0 * x / scale, np.ones(len(x))])
    solution = cast(FloatArray, np.linalg.lstsq(system, (x * x).sum(axis=1) / scale**2, rcond=None)[0])
    square = solution[-1] + solution[:-1] @ solution[:-1]
    return middle + scale * solution[:-1], scale * float(np.sqrt(max(square, 0.0)))


def _resampled(ring: FloatArray) -> FloatArray:
    """`OUTLINE_SAMPLES` points (k, 2) at equal steps along the closed polygon `ring` (n, 2)."""
    closed = np.concatenate([ring, ring[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    steps = np.linspace(0.0, float(along[-1]), OUTLINE_SAMPLES, endpoint=False)
    return np.stack([np.interp(steps, along, closed[:, k]) for k in range(2)], axis=1)


def _floats(values: FloatArray) -> tuple[float, ...]:
    return tuple(float(v) for v in values)
