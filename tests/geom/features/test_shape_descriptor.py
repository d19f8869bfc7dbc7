"""A descriptor stays under rotation, scale, translation and another tessellation, and differs for another shape."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from geom.features.shape_descriptor import descriptor_distances, shape_descriptor, vector_of
from schemas.arrays import FloatArray, IntArray

TURN = Rotation.from_euler("xyz", [40.0, -73.0, 110.0], degrees=True).as_matrix()
SHAPES = {
    "box": trimesh.creation.box((0.3, 0.2, 0.1)),
    "cube": trimesh.creation.box((0.1, 0.1, 0.1)),
    "cylinder": trimesh.creation.cylinder(0.04, 0.1),
    "ring": trimesh.creation.annulus(0.03, 0.05, 0.02),
    "cone": trimesh.creation.cone(0.05, 0.1),
}


def surface(name: str) -> tuple[FloatArray, IntArray]:
    return np.array(SHAPES[name].vertices), np.array(SHAPES[name].faces, dtype=np.int32)


def distance(a: tuple[FloatArray, IntArray], b: tuple[FloatArray, IntArray]) -> float:
    first, second = shape_descriptor(*a), shape_descriptor(*b)
    assert first is not None
    assert second is not None
    return float(descriptor_distances(vector_of(first), vector_of(second)[None])[0])


@pytest.mark.parametrize("name", SHAPES)
def test_moments_and_scale_of_a_turned_and_scaled_copy_are_exact(name: str):
    points, triangles = surface(name)
    here = shape_descriptor(points, triangles)
    there = shape_descriptor(2.5 * points @ TURN.T + 7.0, triangles[::-1])
    assert here is not None
    assert there is not None
    np.testing.assert_allclose(there.second_moments, here.second_moments, atol=2e-5)
    np.testing.assert_allclose(there.third_moments, here.third_moments, atol=2e-5)
    assert there.scale_m == pytest.approx(2.5 * here.scale_m)


@pytest.mark.parametrize("name", SHAPES)
def test_another_tessellation_is_nearer_than_any_other_shape(name: str):
    finer = SHAPES[name].subdivide()
    copy = np.array(finer.vertices), np.array(finer.faces, dtype=np.int32)
    own = distance(surface(name), copy)
    assert own < 0.015
    assert all(distance(surface(other), copy) > 1.5 * own for other in SHAPES if other != name)


def test_second_moments_are_those_of_the_closed_form():
    """A thin-walled cube of edge 1: each moment is 1/3 of the whole, rms distance from the centre sqrt(5/12)."""
    points, triangles = surface("cube")
    shape = shape_descriptor(10.0 * points, triangles)
    assert shape is not None
    np.testing.assert_allclose(shape.second_moments, 1.0 / 3.0, atol=1e-5)
    assert shape.scale_m == pytest.approx(np.sqrt(5.0 / 12.0))


def test_a_surface_without_area_has_none():
    assert shape_descriptor(np.zeros((3, 3)), np.array([[0, 1, 2]], dtype=np.int32)) is None
    assert shape_descriptor(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)) is None
