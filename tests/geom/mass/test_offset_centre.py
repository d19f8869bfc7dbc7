"""Squeezed mass fits inside the shape about any centre in it, turns with it, and is the even filling at its centre."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from geom.mass.inertia import enclosed_volume, is_physical
from geom.mass.inertia_bounds import rms_distance_and_bound
from geom.mass.offset_centre import contracted_inertia, contraction_about, relative_depth
from tests.support.sample_surfaces import ball, box, cylinder

BODIES = {"box": box((0.08, 0.05, 0.2)), "ball": ball(), "cylinder": cylinder(), "plate": box((0.3, 0.2, 0.004))}


def tensor_about(centre, surface):
    points, triangles = surface
    even = enclosed_volume(points, triangles)
    per_kg = even.second_moment_m5 / even.volume_m3
    return contracted_inertia(per_kg, contraction_about(centre, points, even.centre_m, per_kg)), per_kg


@pytest.mark.parametrize("name", BODIES)
@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_it_fits_wherever_the_centre_is_and_turns_with_the_shape(name, seed):
    points, triangles = BODIES[name]
    rng = np.random.default_rng(seed)
    centre = rng.dirichlet(np.full(len(points), rng.uniform(0.02, 1.0))) @ points
    found, even = tensor_about(centre, (points, triangles))
    assert is_physical(found, 1e-9)
    value, bound = rms_distance_and_bound(found, points - centre)
    assert value <= bound
    assert np.trace(found) <= np.trace(even) * (1.0 + 1e-9)
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    turned, _ = tensor_about(R @ centre, (points @ R.T, triangles))
    assert_allclose(turned, R @ found @ R.T, atol=1e-7 * np.trace(even))


def test_at_the_even_centre_it_is_the_even_filling():
    points, triangles = BODIES["box"]
    found, even = tensor_about(enclosed_volume(points, triangles).centre_m, BODIES["box"])
    assert_allclose(found, even, rtol=1e-9)


def test_a_low_centre_flattens_only_the_height_and_only_as_far_as_it_must():
    """At 2 % of the height of a box the mass may reach 0.14 of the height; at a quarter the even filling fits."""
    points, triangles = BODIES["box"]
    middle = enclosed_volume(points, triangles).centre_m
    found, _ = tensor_about(middle - [0.0, 0.0, 0.096], BODIES["box"])
    x, y, z = 0.08**2 / 12.0, 0.05**2 / 12.0, 0.8**2 * 0.004 * 0.196
    assert_allclose(found, np.diag([y + z, x + z, x + y]), atol=1e-12)
    found, even = tensor_about(middle - [0.0, 0.0, 0.05], BODIES["box"])
    assert_allclose(found, even, atol=1e-12)


def test_depth_below_the_skin():
    points, _ = BODIES["box"]
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    at = [relative_depth(np.array([*middle[:2], low[2] + share * 0.2]), points, middle) for share in (0.02, 0.0, -0.01)]
    assert_allclose(at, [0.02, 0.0, -0.01], atol=1e-9)
    assert relative_depth(middle, points, middle) == 0.5
