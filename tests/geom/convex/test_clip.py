"""What is left of a convex shape in a box."""

from __future__ import annotations

import numpy as np
import pytest

from geom.convex.clip import clipped_shape
from geom.convex.hull import volume
from geom.convex.support_function import surface
from geom.pose import pose, rotation_about
from schemas.physics import CollisionShape


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_a_box_cut_by_a_box_is_their_intersection(size: float) -> None:
    shape = CollisionShape("box", (2.0 * size,) * 3, pose())
    part = clipped_shape(shape, size * np.array([0.0, -0.5, -9.0]), size * np.array([9.0, 0.5, 9.0]))
    assert part is not None
    points, triangles = surface(part)
    assert points.min(axis=0) == pytest.approx(size * np.array([0.0, -0.5, -1.0]))
    assert points.max(axis=0) == pytest.approx(size * np.array([1.0, 0.5, 1.0]))
    assert volume(points, triangles) == pytest.approx(2.0 * size**3)


def test_parts_on_both_sides_of_a_plane_make_up_the_whole() -> None:
    shape = CollisionShape("cylinder", (0.3, 1.0), pose(rotation_about((1.0, 2.0, 3.0), 0.7)))
    far = 5.0 * np.ones(3)
    parts = [
        clipped_shape(shape, -far, np.array([5.0, 0.1, 5.0])),
        clipped_shape(shape, np.array([-5.0, 0.1, -5.0]), far),
    ]
    volumes = [volume(*surface(part)) for part in parts if part is not None]
    assert len(volumes) == 2
    assert sum(volumes) == pytest.approx(volume(*surface(shape)), rel=1e-3)


def test_outside_there_is_nothing_and_inside_all() -> None:
    shape = CollisionShape("sphere", (1.0,), pose())
    assert clipped_shape(shape, np.full(3, 2.0), np.full(3, 3.0)) is None
    assert clipped_shape(shape, np.full(3, -2.0), np.full(3, 2.0)) is shape
