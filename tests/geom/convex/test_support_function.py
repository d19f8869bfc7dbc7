"""Support functions against sampled surfaces and closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from geom.convex.support_function import (
    bounds,
    centre_heights,
    diagonal,
    facet_directions,
    heights,
    stability_margin,
    support,
    surface,
)
from geom.pose import pose
from schemas.physics import CollisionShape
from tests.support.sample_bodies import box, capsule, cylinder, hull, sphere

BODIES = [
    box((0.1, 0.2, 0.3)),
    sphere(0.1),
    cylinder(0.1, 0.3),
    capsule(0.1, 0.2),
    hull(trimesh.creation.icosphere(subdivisions=1)),
]


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000))
@pytest.mark.parametrize("body", BODIES, ids=lambda b: b.name)
def test_support_is_the_furthest_point_of_the_surface(body, seed: int) -> None:
    """Tessellations are inscribed: they reach as far or, where curved, up to 0.3 % of the size less."""
    turned, direction = Rotation.random(2, rng=np.random.default_rng(seed)).as_matrix()
    shape = body.shapes[0]
    moved = CollisionShape(shape.kind, shape.size_m, pose(turned, (1.0, 2.0, 3.0)), shape.points, shape.triangles)
    points, _ = surface(moved)
    exact = support([moved], direction[:1])[0]
    reached = float((points @ direction[0]).max())
    assert reached <= exact + 1e-12
    assert reached >= exact - 0.003 * diagonal([moved])


def test_bounds_and_diagonal_of_a_compound() -> None:
    shapes = (*box((0.1, 0.2, 0.3)).shapes, *sphere(0.3).shapes)
    assert bounds(shapes).tolist() == [[-0.3, -0.3, 0.0], [0.3, 0.3, 0.6]]
    assert diagonal(shapes) == pytest.approx(np.sqrt(3) * 0.6)


def test_heights_over_the_ground() -> None:
    shapes = cylinder(0.1, 0.3).shapes
    lying = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    origins = np.array([[0.0, 0.0, 1.0], [5.0, 0.0, 1.0]])
    assert heights(shapes, origins, np.stack([np.eye(3), lying])) == pytest.approx([1.0, 0.9])


def test_height_of_the_mass_centre_over_each_face() -> None:
    body = box((0.1, 0.2, 0.3))
    levels = centre_heights(body.shapes, np.asarray(body.mass.centre_of_mass_m), -np.eye(3))
    assert levels == pytest.approx([0.05, 0.1, 0.15])


def test_foot_of_a_box_is_half_its_shorter_edge() -> None:
    body = box((0.1, 0.2, 0.3))
    lever, tipped = stability_margin(body.shapes, np.asarray(body.mass.centre_of_mass_m), np.array([0.0, 0.0, -1.0]))
    assert lever == pytest.approx(0.05, abs=0.3 * np.sin(np.radians(0.5)))
    assert abs(tipped[0]) == pytest.approx(np.sin(np.radians(1.0)), rel=1e-4)


@given(st.floats(0.0, np.pi))
def test_what_rolls_has_no_foot_whichever_way_it_lies(yaw: float) -> None:
    rod = cylinder(0.01, 0.3)
    down = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    lever, _ = stability_margin(rod.shapes, np.asarray(rod.mass.centre_of_mass_m), down)
    assert abs(lever) < 0.003 * diagonal(rod.shapes)


def test_what_stands_on_its_edge_has_less_than_no_foot() -> None:
    body = box((0.1, 0.2, 0.3))
    on_edge = np.array([0.05, 0.0, -0.15]) / np.hypot(0.05, 0.15)
    assert stability_margin(body.shapes, np.asarray(body.mass.centre_of_mass_m), on_edge)[0] < 0.0


def test_facets_of_a_box_and_of_a_flat_thing() -> None:
    assert sorted(map(tuple, facet_directions(box((1, 2, 3)).shapes))) == sorted(
        tuple(float(v) for v in s * axis) for axis in np.eye(3) for s in (-1, 1)
    )
    flat = CollisionShape("hull", (), np.eye(4), np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    assert facet_directions([flat]).shape == (0, 3)


@pytest.mark.parametrize("count", [1, 5, 3000])
def test_many_hulls_together_give_the_same_bits_as_one_by_one(count: int) -> None:
    """Hulls in the asset frame are taken together; a posed one, a box and a ball go their own way."""
    rng = np.random.default_rng(3)
    hulls = [CollisionShape("hull", (), np.eye(4), rng.normal(size=(20 + n, 3)) + n) for n in range(6)]
    posed = replace(hulls[0], X_AS=pose(Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix(), (1.0, 2.0, 3.0)))
    shapes = [*hulls, posed, *box((0.1, 0.2, 0.3)).shapes, *sphere(0.2).shapes]
    directions = rng.normal(size=(count, 3))
    one_by_one = np.max([support([shape], directions) for shape in shapes], axis=0)
    assert np.array_equal(support(shapes, directions), one_by_one)
