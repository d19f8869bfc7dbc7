"""No mass inside a shape lies further from its centre than the bound says; mass at two ends lies as far."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geom.mass.inertia_bounds import rms_distance_and_bound


def tensor(points, weights):
    """Per kilogram about the mass centre, and the centre."""
    centre = weights @ points
    d = points - centre
    return np.einsum(
        "n,nij->ij", weights, (d * d).sum(1)[:, None, None] * np.eye(3) - d[:, :, None] * d[:, None]
    ), centre


@settings(max_examples=50, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), uneven=st.floats(0.05, 20.0))
def test_no_mass_inside_reaches_further(seed, uneven):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(12, 3)) * rng.uniform(0.1, 1.0, size=3)
    weights = rng.gamma(1.0 / uneven, size=12) + 1e-12
    inertia, centre = tensor(points, weights / weights.sum())
    value, bound = rms_distance_and_bound(inertia, points - centre)
    assert value <= bound * (1.0 + 1e-6)


def test_a_dumbbell_of_two_points_is_the_limit_and_anything_more_is_beyond_it():
    ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    inertia, centre = tensor(ends, np.array([0.3, 0.7]))
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]) - centre
    value, bound = rms_distance_and_bound(inertia, corners)
    assert value == pytest.approx(bound) == pytest.approx(np.sqrt(0.21))
    assert np.subtract(*rms_distance_and_bound(1.1 * inertia, corners)) > 0.0


def test_a_centre_outside_has_no_bound():
    assert rms_distance_and_bound(np.eye(3), np.array([[1.0, 1, 1], [2, 2, 2], [1, 2, 1]])) == (0.0, 0.0)
