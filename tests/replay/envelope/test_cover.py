"""Balls around convex solids: nothing of the solid outside all balls, no ball far outside the solid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from geom.convex.circumscribed_hull import circumscribed_hull
from geom.pose import pose
from replay.envelope.cover import cover
from schemas.physics import CollisionShape

BOX = CollisionShape("box", (0.2, 0.1, 0.03), pose(None, np.array([0.1, 0.0, 0.4])))
SHAPES = {
    "box": BOX,
    "plate": CollisionShape("box", (0.1, 0.1, 0.001), np.eye(4)),
    "cylinder": CollisionShape("cylinder", (0.03, 0.2), np.eye(4)),
    "capsule": CollisionShape("capsule", (0.03, 0.2), np.eye(4)),
}


def inside(corners, rng, n=3000):
    """Points (n, 3) of the hull of `corners`, its corners and points near its faces among them."""
    weights = rng.dirichlet(np.full(len(corners), 0.3), n)
    return np.concatenate([corners, weights @ corners])


def farthest_out(found, points):
    away = np.linalg.norm(points[:, None] - found.centres_B, axis=2) - found.radii_m
    return float(away.min(axis=1).max())


def check(shape, protrusion_m):
    covered = cover([shape], protrusion_m)
    corners = circumscribed_hull(shape)
    assert farthest_out(covered, inside(corners, np.random.default_rng(0))) <= covered.residual_m
    hull = ConvexHull(corners)
    on_balls = covered.centres_B[:, None] + covered.radii_m[:, None, None] * directions()
    beyond = on_balls @ hull.equations[:, :3].T + hull.equations[:, 3]
    assert beyond.max() <= covered.protrusion_m + 1e-12
    return covered


def directions(n=200):
    points = np.random.default_rng(1).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.mark.parametrize("kind", SHAPES)
def test_all_of_a_shape_lies_in_its_balls(kind):
    found = check(SHAPES[kind], 0.006)
    assert (
        found.protrusion_m
        <= max(0.006, 0.03 * np.linalg.norm(np.ptp(circumscribed_hull(SHAPES[kind]), axis=0))) + 1e-12
    )
    assert found.residual_m < 1e-9


@settings(max_examples=15)
@given(st.integers(0, 10_000), st.integers(4, 40), st.floats(0.02, 0.5))
def test_all_of_any_hull_lies_in_its_balls(seed, count, size):
    points = size * np.random.default_rng(seed).normal(size=(count, 3))
    check(CollisionShape("hull", (), np.eye(4), points, None), 0.4 * size)


@pytest.mark.parametrize("size_m", [(0.1, 0.1, 1e-13), (0.1, 1e-13, 1e-13)])
def test_what_is_all_but_flat_is_covered_at_any_angle(size_m):
    """Qhull refused its cuts, or the cover allocated 96 GiB."""
    X = pose(Rotation.from_rotvec([0.3, 0.5, 0.2]).as_matrix(), np.array([1.0, 2.0, 3.0]))
    for X_BS in (np.eye(4), X):
        shape = CollisionShape("box", size_m, X_BS)
        found = cover([shape], 0.006)
        assert farthest_out(found, inside(circumscribed_hull(shape), np.random.default_rng(0))) <= found.residual_m
        assert len(found.radii_m) < 600


def test_tighter_covers_take_more_balls():
    counts = [len(check(BOX, protrusion_m).radii_m) for protrusion_m in (0.03, 0.015, 0.007)]
    assert counts == sorted(counts)
    assert counts[0] < counts[-1] < 400


def test_a_ball_is_its_own_cover_and_nothing_needs_none():
    found = cover([CollisionShape("sphere", (0.05,), pose(None, np.array([1.0, 2.0, 3.0])))], 0.001)
    assert found.radii_m.tolist() == [0.05]
    assert found.protrusion_m == 0.0
    assert len(cover([], 0.01).radii_m) == 0
