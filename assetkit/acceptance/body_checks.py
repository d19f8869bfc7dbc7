"""Static checks of a body as re-read from disk: colliders, mass and inertia are plausible and match the visual mesh."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geom.convex import hull
from geom.convex.support_function import bounds, diagonal
from geom.mass.inertia import TRIANGLE_INEQUALITY_TOLERANCE
from geom.mesh.surface_distance import sample_surface
from schemas.acceptance import Check
from schemas.arrays import FloatArray, IntArray
from schemas.asset import Vec3
from schemas.physics import CollisionShape, RigidBody

MAX_SHAPES, MAX_HULL_POINTS = 64, 64
_OF_DIAGONAL = "of diagonal"
_SMALLEST_SINGLE = float(np.finfo(np.float32).tiny)  # USD holds mass and inertia in single precision


def frame_checks(visual_points: FloatArray, extent_m: Vec3 | None) -> list[Check]:
    """Whether the bottom centre of the visible points (n, 3) is at the origin and their extent that of the record, if
    given; both within 0.1 % of the diagonal.
    """
    low, high = visual_points.min(axis=0), visual_points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    bottom_centre = np.array([(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, low[2]])
    checks = [_at_most("origin_at_bottom_centre", float(np.linalg.norm(bottom_centre)) / size, 1e-3, _OF_DIAGONAL)]
    if extent_m is not None:
        error = float(np.abs(high - low - np.asarray(extent_m)).max()) / size
        checks.append(_at_most("extent_equals_record", error, 1e-3, _OF_DIAGONAL))
    return checks


def alignment_checks(body: RigidBody, points: FloatArray, triangles: IntArray) -> list[Check]:
    """Whether colliders are where the visible surface (points (n, 3), triangles (m, 3)) is.

    The boxes' corners agree within 5 % of the diagonal, and 95 % of the visible surface lies inside the colliders or
    within 5 % of the diagonal outside. How far colliders reach beyond the surface is measured when they are chosen.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.linalg.norm(high - low))
    corners = float(np.abs(bounds(body.shapes) - np.stack([low, high])).max())
    samples, _ = sample_surface(points, triangles, 2000, seed=0)
    outside = np.min([distance_outside(shape, samples) for shape in body.shapes], axis=0)
    return [
        _at_most("collider_box_offset", corners / size, 0.05, _OF_DIAGONAL),
        _at_most("visual_outside_collider_p95", float(np.percentile(outside, 95)) / size, 0.05, _OF_DIAGONAL),
    ]


def body_checks(body: RigidBody) -> list[Check]:
    """Whether colliders are few, small, convex and solid, and mass, mass centre and inertia physically possible."""
    checks = [
        _at_least("collider_count", len(body.shapes), 1, ""),
        _at_most("collider_count_limit", len(body.shapes), MAX_SHAPES, ""),
        _at_least("mass", body.mass.mass_kg, _SMALLEST_SINGLE, "kg"),
    ]
    if not body.shapes:
        return checks
    size = diagonal(body.shapes)
    hulls = [(s.points, s.triangles) for s in body.shapes if s.points is not None and s.triangles is not None]
    edges = [float(edge) / size for s in body.shapes for edge in s.size_m]
    thin = [hull.thickness(*h) / size if _has_volume(*h) else 0.0 for h in hulls]
    checks.append(_at_least("collider_thickness", min(edges + thin, default=0.0), 1e-7, _OF_DIAGONAL))
    if hulls:
        dents = [_dent(*h) / size for h in hulls]
        checks.append(_at_most("hull_points", max(len(points) for points, _ in hulls), MAX_HULL_POINTS, ""))
        checks.append(_at_most("hull_not_convex_by", max(dents), 1e-4, _OF_DIAGONAL))
    return checks + _mass_checks(body, size)


def _mass_checks(body: RigidBody, size: float) -> list[Check]:
    low, high = bounds(body.shapes)
    centre, inertia = np.asarray(body.mass.centre_of_mass_m), np.asarray(body.mass.inertia_kgm2)
    outside = float(np.maximum(np.maximum(low - centre, centre - high), 0.0).max())
    small, middle, large = np.linalg.eigvalsh(inertia) if np.isfinite(inertia).all() else (np.nan,) * 3
    surplus = float((small + middle - large) / large) if large > 0.0 else -1.0
    # No point of the body is further from the mass centre than the diagonal.
    gyration = float(np.sqrt(max(large, 0.0) / body.mass.mass_kg)) if body.mass.mass_kg > 0.0 else np.inf
    return [
        _at_most("mass_centre_outside_box", outside / size, 0.01, _OF_DIAGONAL),
        _at_least("inertia_smallest_moment", float(small), _SMALLEST_SINGLE, "kg m2"),
        _at_least("inertia_triangle_surplus", surplus, -TRIANGLE_INEQUALITY_TOLERANCE, "of largest moment"),
        _at_most("radius_of_gyration", gyration / size, 1.0, _OF_DIAGONAL),
    ]


def distance_outside(shape: CollisionShape, points: FloatArray) -> FloatArray:
    """How far (k,) points lie outside one shape, 0 inside; for hulls a lower bound, exact over faces."""
    local = (points - shape.X_AS[:3, 3]) @ shape.X_AS[:3, :3]
    if shape.kind == "hull":
        assert shape.points is not None, "a hull has points"
        planes = _planes(shape.points)
        return np.maximum((local @ planes[:, :3].T + planes[:, 3]).max(axis=1), 0.0)
    local = np.abs(local)
    if shape.kind == "box":
        return np.linalg.norm(np.maximum(local - np.asarray(shape.size_m) / 2.0, 0.0), axis=1)
    radius, half = shape.size_m[0], (shape.size_m[1] / 2.0 if len(shape.size_m) > 1 else 0.0)
    across, along = np.linalg.norm(local[:, :2], axis=1), np.maximum(local[:, 2] - half, 0.0)
    if shape.kind == "cylinder":
        return np.hypot(np.maximum(across - radius, 0.0), along)
    return np.maximum(np.hypot(across, along) - radius, 0.0)


def _dent(points: FloatArray, triangles: IntArray) -> float:
    """How deep (m) the surface lies below the hull of its own points: 0 for a convex surface, infinite inside out.

    Measured in the middle of every edge and face. Planes of the faces themselves are no basis: single precision turns
    the plane of a sliver by any angle, while its points hardly move.
    """
    if hull.volume(points, triangles) < 0.0:
        return np.inf
    corners = points[triangles]
    middles = np.concatenate([0.5 * (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3), corners.mean(axis=1)])
    planes = _planes(points)
    return max(0.0, float(-(middles @ planes[:, :3].T + planes[:, 3]).max(axis=1).min()))


def _planes(points: FloatArray) -> FloatArray:
    """(m, 4) outward planes `n . x + d = 0` of the convex hull of points; none when they are flat."""
    try:
        return np.asarray(ConvexHull(points).equations)
    except QhullError:
        return np.zeros((1, 4))


def _has_volume(points: FloatArray, triangles: IntArray) -> bool:
    return len(triangles) >= 4 and hull.volume(points, triangles) > 0.0


def _at_most(name: str, value: float, bound: float, unit: str) -> Check:
    return Check(name=name, value=float(value), bound=float(bound), unit=unit, passed=bool(value <= bound))


def _at_least(name: str, value: float, bound: float, unit: str) -> Check:
    return Check(name=name, value=float(value), bound=float(bound), unit=unit, passed=bool(value >= bound))
