"""Fitting a shape to its own points gives the shape back, wherever and however it lies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from geom.convex.hull import contains, convex_hull, hull_shape, reduced_hull, thickness, volume
from geom.convex.primitive_fits import fit_box, fit_capsule, fit_cylinder, fit_sphere
from geom.convex.support_function import surface
from geom.pose import pose
from schemas.physics import CollisionShape

FITS = {"box": fit_box, "sphere": fit_sphere, "cylinder": fit_cylinder, "capsule": fit_capsule}
SIZES = {"box": (0.3, 0.2, 0.1), "sphere": (0.2,), "cylinder": (0.1, 0.5), "capsule": (0.1, 0.3)}


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**31))
@pytest.mark.parametrize("kind", sorted(FITS))
def test_a_turned_and_moved_shape_is_found_again(kind, seed):
    rng = np.random.default_rng(seed)
    X_AS = pose(Rotation.random(rng=np.random.default_rng(seed)).as_matrix(), rng.uniform(-5, 5, 3))
    scale = 10.0 ** rng.uniform(-3, 1)
    X_AS[:3, 3] *= scale
    shape = CollisionShape(kind, tuple(scale * s for s in SIZES[kind]), X_AS)
    fitted = FITS[kind](surface(shape)[0])
    assert fitted is not None
    assert fitted.kind == kind
    size = sorted(fitted.size_m) if kind == "box" else fitted.size_m
    expected = sorted(shape.size_m) if kind == "box" else shape.size_m
    assert_allclose(size, expected, rtol=5e-3)
    assert_allclose(fitted.X_AS[:3, 3], X_AS[:3, 3], atol=1e-3 * scale)
    assert_allclose(fitted.X_AS[:3, :3] @ fitted.X_AS[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(fitted.X_AS[:3, :3]) == pytest.approx(1.0)
    if kind in ("cylinder", "capsule"):
        assert abs(fitted.X_AS[:3, 2] @ X_AS[:3, 2]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_a_plane_however_turned_has_no_box(seed: int):
    """Turned by hand, a plane is as thick as its rounding: the smallest oriented box of it has no meaning."""
    plane = np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    assert fit_box(plane @ Rotation.random(rng=np.random.default_rng(seed)).as_matrix().T + 3.0) is None
    assert fit_box(plane + [[0.0, 0.0, k * 1e-17] for k in range(4)]) is None


def test_a_box_nearly_along_the_axes_stays_along_the_axes():
    turned = CollisionShape("box", (0.3, 0.2, 0.1), pose(Rotation.from_euler("z", 0.3, degrees=True).as_matrix()))
    found = fit_box(surface(turned)[0])
    assert found is not None
    assert_allclose(found.X_AS[:3, :3], np.eye(3))


def test_flat_points_have_no_fit():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    assert [fit(square) for fit in FITS.values()] == [None] * 4
    assert hull_shape(square) is None


def test_no_capsule_in_a_cube():
    assert fit_capsule(surface(CollisionShape("box", (1.0, 1.0, 1.0), np.eye(4)))[0]) is None


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31))
def test_a_reduced_hull_has_few_points_the_same_volume_and_is_convex(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(400, 3))
    points = points / np.linalg.norm(points, axis=1, keepdims=True) * rng.uniform(0.01, 1.0, 3) + 100.0
    full = convex_hull(points)
    reduced, triangles = reduced_hull(points, 64)
    assert len(reduced) <= 64
    assert volume(reduced, triangles) == pytest.approx(volume(*full), rel=1e-6)
    size = np.ptp(points, axis=0).max()
    assert contains(reduced, triangles, reduced, 1e-5 * size).all()
    assert contains(reduced, triangles, full[0], 0.06 * size).all()
    assert volume(*convex_hull(reduced)) == pytest.approx(volume(reduced, triangles), rel=1e-6)


def test_the_thickness_of_a_plate():
    plate = surface(
        CollisionShape("box", (0.3, 0.2, 0.004), pose(Rotation.random(rng=np.random.default_rng(1)).as_matrix()))
    )[0]
    assert thickness(*convex_hull(plate)) == pytest.approx(0.004)
