"""Rays and boxes against unions of convex shapes, beside what is known of boxes and balls."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geom.convex.convex_union import ConvexUnion
from geom.pose import pose
from schemas.physics import CollisionShape

# Two boxes that overlap make one bar of 0.3 m; a third stands 0.1 m behind it.
BAR = [
    CollisionShape("box", (0.2, 0.1, 0.1), pose(None, (0.0, 0.0, 0.0))),
    CollisionShape("box", (0.2, 0.1, 0.1), pose(None, (0.1, 0.0, 0.0))),
    CollisionShape("box", (0.1, 0.1, 0.1), pose(None, (0.35, 0.0, 0.0))),
]
START, ALONG = np.array([[-0.1, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])


def turned(seed: int) -> np.ndarray:
    return Rotation.random(rng=np.random.default_rng(seed)).as_matrix()


def test_a_ray_goes_on_through_shapes_that_touch_and_ends_at_the_first_gap():
    reach, normal = ConvexUnion(BAR).first_exit(START, ALONG)
    assert reach[0] == pytest.approx(0.3)
    assert normal[0] == pytest.approx([1.0, 0.0, 0.0])


def test_a_ray_from_outside_enters_the_first_shape_that_it_meets():
    starts = np.array([[-0.5, 0.0, 0.0], [0.25, 0.04, 0.0], [0.6, 0.0, 0.0], [-0.5, 0.06, 0.0]])
    reach = ConvexUnion(BAR).first_entry(starts, np.repeat(ALONG, 4, axis=0))
    assert reach == pytest.approx([0.4, 0.05, np.inf, np.inf])


def test_the_last_exit_is_behind_the_gap():
    assert ConvexUnion(BAR).last_exit(START, ALONG)[0][0] == pytest.approx(0.5)


def test_outer_samples_lie_on_no_face_inside_another_shape():
    points, _ = ConvexUnion(BAR).outer_samples(2000)
    inner = (np.abs(points[:, 0]) < 0.0999) & (np.abs(points[:, 1:]) < 0.0499).all(axis=1)
    assert not inner.any()


@pytest.mark.parametrize("seed", range(20))
def test_a_box_called_clear_holds_no_point_of_the_shapes(seed: int):
    rng = np.random.default_rng(seed)
    shapes = [
        CollisionShape(
            "cylinder",
            (0.03, 0.1),
            pose(turned(seed), (0.01, 0.0, 0.05)),
        )
    ]
    union = ConvexUnion([*BAR[:1], *shapes])
    poses = np.stack([pose(turned(k), rng.normal(0.0, 0.1, 3)) for k in range(50)])
    half = np.tile([0.03, 0.02, 0.01], (50, 1))
    clear = union.box_clear(poses, half)
    assert clear.any()
    assert not clear.all()
    inside = rng.uniform(-1.0, 1.0, (500, 3)) * half[0]
    for k in np.flatnonzero(clear):
        assert not union.inside(inside @ poses[k, :3, :3].T + poses[k, :3, 3]).any()
