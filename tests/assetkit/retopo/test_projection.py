"""A place is projected onto the side of the source that looks its way, however near the other side is."""

from __future__ import annotations

import numpy as np

from assetkit.retopo.projection import Projector
from schemas.model import Mesh

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def sheet(height: float, up: bool) -> tuple[np.ndarray, np.ndarray]:
    points = np.insert(SQUARE, 2, height, axis=1)
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return points, faces if up else faces[:, ::-1]


def slab(thickness: float) -> Mesh:
    """A top at height 0 and a bottom below it: triangles 0, 1 look up, 2, 3 look down."""
    (top, up), (bottom, down) = sheet(0.0, True), sheet(-thickness, False)
    return Mesh("slab", np.concatenate([top, bottom]), np.concatenate([up, down + 4]).astype(np.int32))


UP = np.array([[0.0, 0.0, 1.0]])


def test_both_sides_of_a_thin_slab_are_told_apart_from_above_and_from_within() -> None:
    """The light surface may lie beyond the other side: the nearest place would be the wrong one."""
    projector = Projector(slab(0.02))
    for height in (0.03, -0.005, -0.019, -0.03):
        place = np.array([[0.3, 0.2, height]])
        assert projector(place, UP, 0.1).faces[0] in (0, 1)
        assert projector(place, -UP, 0.1).faces[0] in (2, 3)


def test_beyond_reach_the_nearest_place_is_taken_and_counted() -> None:
    there = Projector(slab(0.02))(np.array([[0.3, 0.2, 0.5], [0.3, 0.2, 0.05]]), np.repeat(UP, 2, axis=0), 0.1)
    assert there.by_ray.tolist() == [0.0, 1.0]
    assert there.faces[0] in (0, 1)


def test_the_place_is_straight_along_the_ray() -> None:
    mesh = slab(0.5)
    slanted = np.array([[0.6, 0.0, 0.8]])
    there = Projector(mesh)(np.array([[0.0, 0.0, 0.04]]), slanted, 0.1)
    place = there.weights[0] @ mesh.points[mesh.triangles[there.faces[0]]]
    np.testing.assert_allclose(place, [-0.03, 0.0, 0.0], atol=1e-5)


def test_the_reach_covers_the_largest_distance() -> None:
    assert 0.3 < Projector(slab(0.5)).reach_to(np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.3]])) < 0.6
