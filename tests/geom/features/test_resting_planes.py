"""Hulls end where the body stands: what has a flat base stands upright on its colliders."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from assetkit.colliders.decompose import DecompositionSettings, decompose
from geom.convex.hull import MAX_POINTS, centroid, hull_shape
from geom.convex.support_function import surface
from geom.decomposition.simplified_body import simplify_body
from geom.features.resting_planes import HalfSpaces, hull_within, resting_planes
from geom.mesh.manifold_arrays import manifold_arrays
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape
from tests.support.present import present


def turned(outline: list[tuple[float, float]]) -> Manifold:
    """The outline (radius, height) turned about z."""
    return Manifold.revolve(CrossSection([np.array(outline)]), 32)


def pitcher() -> Manifold:
    """A bellied vessel with a foot of half its width, wall 4 mm, base 5 mm, metres, standing at z = 0."""
    height = np.linspace(0.0, 0.2, 21)
    radius = 0.04 + 0.04 * np.sin(np.pi * height / 0.24)
    outer = [(0.0, 0.0), *zip(radius, height, strict=True), (0.0, 0.2)]
    inner = [(0.0, 0.005), *((r - 0.004, h) for r, h in zip(radius, height + 0.005, strict=True)), (0.0, 0.205)]
    return turned(outer) - turned(inner)


def rest_tilt_rad(points: np.ndarray, centre: np.ndarray, down: np.ndarray) -> float:
    """Angle between `down` and the facet of the hull of points (n, 3) on which the body comes to rest from there.

    It tips from facet to facet, as long as that brings the mass centre (3,) lower.
    """
    facets = ConvexHull(points).equations
    height = -(facets[:, :3] @ centre + facets[:, 3])
    below, lowest = down, np.inf
    while True:
        toward = facets[:, :3] @ below
        facet = int(np.where(toward > 1e-9, height / np.maximum(toward, 1e-9), np.inf).argmin())
        if height[facet] >= lowest - 1e-12:
            return float(np.arccos(np.clip(below @ down, -1.0, 1.0)))
        below, lowest = facets[facet, :3], height[facet]


def test_a_vessel_stands_on_its_colliders_as_upright_as_itself(tmp_path):
    turn = Rotation.random(rng=np.random.default_rng(3)).as_matrix()
    points, triangles = manifold_arrays(pitcher().transform(np.column_stack([turn, turn @ [0.1, -0.2, 0.3]])))
    shapes = decompose(
        simplify_body(points, triangles.astype(np.int32)), DecompositionSettings(method="cuts"), tmp_path
    ).shapes
    assert len(shapes) > 1
    reached = np.concatenate([surface(shape)[0] for shape in shapes])
    ground = resting_planes(points)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    assert ((reached @ ground.normals.T - ground.offsets).max(axis=0) < 1e-4 * size).all()
    centre = centroid(points, triangles)
    assert np.degrees(rest_tilt_rad(reached, centre, turn @ [0.0, 0.0, -1.0])) < 0.2


def test_the_planes_are_the_broad_facets_and_hold_all_points():
    points = manifold_arrays(pitcher())[0]
    ground = resting_planes(points)
    assert [np.isclose(ground.normals, axis, atol=1e-6).all(axis=1).sum() for axis in ([0, 0, 1], [0, 0, -1])] == [1, 1]
    assert (points @ ground.normals.T <= ground.offsets + 1e-12).all()
    assert len(resting_planes(manifold_arrays(Manifold.sphere(0.1, 96))[0]).normals) == 0
    assert len(resting_planes(manifold_arrays(Manifold.cube((1.0, 2.0, 3.0)))[0]).normals) == 6
    assert len(resting_planes(np.zeros((5, 3))).normals) == 0


def hull_points_of(shape: CollisionShape | None) -> FloatArray:
    return present(present(shape).points)


def test_only_what_reaches_through_a_plane_changes():
    dome = manifold_arrays(Manifold.sphere(0.1, 128).trim_by_plane((0.0, 0.0, 1.0), -0.06))[0]
    free, standing = hull_points_of(hull_shape(dome)), hull_points_of(hull_within(dome, resting_planes(dome)))
    assert free[:, 2].min() < -0.061  # The reduced hull grows through the base ...
    assert standing[:, 2].min() == pytest.approx(-0.06, abs=1e-9)  # ... and is cut off there.
    assert len(standing) <= MAX_POINTS
    box = manifold_arrays(Manifold.cube((1.0, 2.0, 3.0)))[0]
    assert np.array_equal(hull_points_of(hull_within(box, resting_planes(box))), hull_points_of(hull_shape(box)))
    assert hull_within(dome, HalfSpaces(np.array([[0.0, 0.0, 1.0]]), np.array([-1.0]))) is None
