"""Mass properties: closed forms, additivity, parallel axis, rotation, linearity, far from the origin."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from geom.convex.hull import convex_hull
from geom.mass.inertia import (
    combine,
    enclosed_volume,
    inertia_about,
    is_physical,
    moved,
    of_box,
    of_capsule,
    of_cylinder,
    of_sphere,
    scaled,
    sheet_volume,
)
from geom.mass.principal_axes import inertia_from_principal, principal_axes
from geom.mesh import primitives
from geom.pose import pose

SIZE_M = (0.3, 0.2, 0.1)
seeds = st.integers(0, 2**32 - 1)


def box_surface(size=SIZE_M, centre=(0.0, 0.0, 0.0)):
    points, triangles, _ = primitives.cube(1.0)
    return points * np.array(size) + np.array(centre), triangles.astype(np.int32)


def random_hull(seed: int):
    rng = np.random.default_rng(seed)
    return convex_hull(rng.normal(size=(24, 3)) * rng.uniform(0.01, 2.0, size=3) + rng.uniform(-3, 3, size=3))


def assert_same(a, b, rtol=1e-9):
    assert_allclose(a.mass_kg, b.mass_kg, rtol=rtol)
    assert_allclose(a.centre_of_mass_m, b.centre_of_mass_m, rtol=rtol, atol=rtol)
    assert_allclose(a.inertia_kgm2, b.inertia_kgm2, rtol=rtol, atol=rtol * np.abs(b.inertia_kgm2).max())


def test_the_surface_integral_of_a_box_is_its_closed_form():
    assert_same(enclosed_volume(*box_surface()).filled(700.0), of_box(SIZE_M, 700.0))


@pytest.mark.parametrize(
    ("exact", "tessellated"),
    [
        (of_sphere(0.2, 500.0), lambda n: primitives.sphere(0.2, n)),
        (of_cylinder(0.1, 0.4, 500.0), lambda n: primitives.cylinder(0.4, 0.1, 0.1, n)),
        (of_capsule(0.1, 0.4, 500.0), lambda n: primitives.capsule(0.4, 0.1, 0.1, n)),
    ],
    ids=["sphere", "cylinder", "capsule"],
)
def test_round_shapes_converge_to_their_closed_forms_with_the_square_of_the_step(exact, tessellated):
    errors = []
    for segments in (48, 96):
        points, triangles, _ = tessellated(segments)
        got = enclosed_volume(points, triangles).filled(500.0)
        errors.append(np.abs(got.inertia_kgm2 - exact.inertia_kgm2).max() / exact.inertia_kgm2.max())
    assert errors[0] < 0.02
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_a_capsule_without_a_tube_is_a_sphere():
    assert_same(of_capsule(0.3, 0.0, 10.0), of_sphere(0.3, 10.0))


def test_a_million_metres_away_nothing_changes():
    points, triangles = random_hull(3)
    near, far = enclosed_volume(points, triangles), enclosed_volume(points + 1e6, triangles)
    # The input itself is rounded to 1e-10 m there.
    assert_allclose(far.volume_m3, near.volume_m3, rtol=1e-8)
    assert_allclose(far.centre_m - 1e6, near.centre_m, atol=1e-8)
    assert_allclose(far.second_moment_m5, near.second_moment_m5, rtol=1e-7, atol=1e-8 * near.second_moment_m5.max())


@settings(max_examples=25, deadline=None)
@given(seeds)
def test_hulls_agree_with_an_independent_implementation_and_are_physical(seed):
    points, triangles = random_hull(seed)
    ours = enclosed_volume(points, triangles).filled(1000.0)
    theirs = trimesh.Trimesh(points, triangles, process=False)
    theirs.density = 1000.0
    assert_allclose(ours.mass_kg, theirs.mass, rtol=1e-9)
    assert_allclose(ours.centre_of_mass_m, theirs.center_mass, rtol=1e-7, atol=1e-9)
    # trimesh integrates about the origin and loses digits to the offset.
    assert_allclose(ours.inertia_kgm2, theirs.moment_inertia, rtol=1e-5, atol=1e-5 * ours.inertia_kgm2.max())
    assert is_physical(ours.inertia_kgm2)


def test_monte_carlo_agrees():
    points, triangles = random_hull(11)
    rng = np.random.default_rng(0)
    low, high = points.min(0), points.max(0)
    samples = rng.uniform(low, high, size=(200_000, 3))
    normals = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    )
    inside = samples[((samples @ normals.T - np.einsum("ij,ij->i", normals, points[triangles[:, 0]])) <= 0).all(axis=1)]
    mass = len(inside) / len(samples) * np.prod(high - low)
    x = inside - inside.mean(0)
    second = mass * x.T @ x / len(x)
    ours = enclosed_volume(points, triangles)
    assert_allclose(ours.volume_m3, mass, rtol=0.02)
    assert_allclose(
        ours.second_moment_m5, np.trace(second) * np.eye(3) - second, atol=0.03 * ours.second_moment_m5.max()
    )


@settings(max_examples=20, deadline=None)
@given(seeds, seeds)
def test_rotation_covariance_and_rebuild_from_principal_axes(seed, turn):
    points, triangles = random_hull(seed)
    X_AB = pose(Rotation.random(rng=np.random.default_rng(turn)).as_matrix(), (0.3, -2.0, 1.0))
    body = enclosed_volume(points, triangles).filled(800.0)
    turned = enclosed_volume(points @ X_AB[:3, :3].T + X_AB[:3, 3], triangles).filled(800.0)
    assert_same(turned, moved(body, X_AB), rtol=1e-8)
    rebuilt = inertia_from_principal(*principal_axes(body.inertia_kgm2))
    assert_allclose(rebuilt, body.inertia_kgm2, rtol=1e-9, atol=1e-12 * body.inertia_kgm2.max())


def test_two_half_boxes_are_one_box():
    left = moved(of_box((0.15, 0.2, 0.1), 700.0), pose(None, (1e3 - 0.075, 5.0, 0.0)))
    right = moved(of_box((0.15, 0.2, 0.1), 700.0), pose(None, (1e3 + 0.075, 5.0, 0.0)))
    assert_same(combine([left, right]), moved(of_box(SIZE_M, 700.0), pose(None, (1e3, 5.0, 0.0))))


def test_parallel_axis():
    rod = of_box((1.0, 1e-4, 1e-4), 1e8)
    assert_allclose(inertia_about(rod, np.array([0.5, 0.0, 0.0]))[1, 1], rod.mass_kg / 3.0, rtol=1e-6)


def test_an_inward_shell_is_hollow():
    outer, inner = box_surface(), box_surface((0.2, 0.1, 0.05))
    points = np.concatenate([outer[0], inner[0]])
    triangles = np.concatenate([outer[1], inner[1][:, ::-1] + len(outer[0])])
    hollow = enclosed_volume(points, triangles).filled(700.0)
    assert_same(combine([hollow, of_box((0.2, 0.1, 0.05), 700.0)]), of_box(SIZE_M, 700.0))


def test_mass_is_linear_in_density():
    points, triangles = random_hull(5)
    assert_same(
        enclosed_volume(points, triangles).filled(2000.0), scaled(enclosed_volume(points, triangles).filled(500.0), 4.0)
    )


def test_a_flat_sheet_is_a_plate_and_its_tensor_is_physical():
    points = np.array([[0, 0, 0], [0.3, 0, 0], [0.3, 0.2, 0], [0, 0.2, 0]], dtype=float)
    sheet = sheet_volume(points, np.array([[0, 1, 2], [0, 2, 3]]), 0.002).filled(900.0)
    assert_same(sheet, moved(of_box((0.3, 0.2, 0.002), 900.0), pose(None, (0.15, 0.1, 0.0))))
    assert is_physical(sheet.inertia_kgm2)


@pytest.mark.parametrize(
    ("tensor", "expected"),
    [
        (np.diag([1.0, 1.0, 1.0]), True),
        (np.diag([1.0, 1.0, 2.0]), True),
        (np.diag([1.0, 1.0, 2.1]), False),
        (np.diag([-1.0, 1.0, 1.0]), False),
        (np.diag([np.nan, 1.0, 1.0]), False),
        (np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), False),
    ],
)
def test_is_physical(tensor, expected):
    assert is_physical(tensor) is expected
