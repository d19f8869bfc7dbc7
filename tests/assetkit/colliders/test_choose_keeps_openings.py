"""A ball of 60 % of the opening, dropped into the chosen colliders in PyBullet, stays inside; a lid keeps it out."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold, OpType
from scipy.spatial.transform import Rotation

from assetkit.colliders.choose import choose_colliders
from geom.convex.hull import hull_shape
from geom.features.cavities import find_cavities
from geom.mesh.manifold_arrays import manifold_arrays
from schemas.physics import Solid
from tests.support.probe_drop import stays_inside


def mug(wall: float = 0.004) -> Manifold:
    body = Manifold.cylinder(0.1, 0.04, 0.04, 32) - Manifold.cylinder(0.1, 0.04 - wall, 0.04 - wall, 32).translate(
        (0, 0, wall)
    )
    ring = Manifold.revolve(CrossSection.circle(0.005, 12).translate((0.028, 0)), 24).rotate((90, 0, 0))
    return body + (ring.translate((0.04, 0, 0.05)) - Manifold.cylinder(0.1, 0.038, 0.038, 32))


def bowl(wall: float = 0.006) -> Manifold:
    whole = Manifold.sphere(0.08, 32) - Manifold.sphere(0.08 - wall, 32)
    return whole.trim_by_plane((0.0, 0.0, -1.0), 0.02)


def box(x: float, y: float, z: float, wall: float) -> Manifold:
    inner = Manifold.cube((x - 2 * wall, y - 2 * wall, z)).translate((wall, wall, wall))
    return Manifold.cube((x, y, z)) - inner


def basket() -> Manifold:
    slots = [Manifold.cube((0.03, 0.5, 0.07)).translate((0.02 + 0.05 * k, -0.1, 0.04)) for k in range(5)]
    return box(0.28, 0.2, 0.15, 0.008) - Manifold.batch_boolean(slots, OpType.Add)


def bottle() -> Manifold:
    outside = [(0, 0), (0.035, 0), (0.035, 0.12), (0.015, 0.16), (0.015, 0.2), (0.011, 0.2), (0.011, 0.16)]
    return Manifold.revolve(CrossSection([np.array([*outside, (0.031, 0.12), (0.031, 0.004), (0, 0.004)])]), 24)


def drawer() -> Manifold:
    dividers = Manifold.cube((0.008, 0.3, 0.09)).translate((0.13, 0, 0)) + Manifold.cube((0.4, 0.008, 0.09)).translate(
        (0, 0.15, 0)
    )
    return box(0.4, 0.3, 0.1, 0.008) + dividers


VESSELS = {
    "mug": (mug, 1),
    "thin mug": (lambda: mug(0.002), 1),
    "bowl": (bowl, 1),
    "bin": (lambda: box(0.25, 0.2, 0.35, 0.003), 1),
    "tray": (lambda: box(0.4, 0.3, 0.05, 0.006), 1),
    "basket": (basket, 1),
    "bottle": (bottle, 1),
    "drawer": (drawer, 4),
}


def solid_of(body: Manifold, R: np.ndarray | None = None, size: float = 1.0) -> Solid:
    points, triangles = manifold_arrays(body)
    return Solid(size * points @ (np.eye(3) if R is None else R).T, triangles.astype(np.int32), "closed")


def containers(solid: Solid):
    return [cavity for cavity in find_cavities(solid) if not cavity.through]


@pytest.mark.parametrize("name", VESSELS)
def test_the_ball_stays_in_the_chosen_colliders_and_not_in_the_hull(name, tmp_path):
    make, count = VESSELS[name]
    solid = solid_of(make())
    openings = containers(solid)
    assert len(openings) == count
    chosen = choose_colliders(solid, tmp_path)
    hull = hull_shape(solid.points)
    assert hull is not None
    for opening in openings:
        assert stays_inside(chosen.shapes, opening)
        assert not stays_inside([hull], opening)


@pytest.mark.parametrize("tilt_deg", [20.0, 45.0, 70.0])
def test_an_askew_vessel_has_its_opening_where_it_looks(tilt_deg):
    R = Rotation.from_euler("xz", [tilt_deg, 25.0], degrees=True).as_matrix()
    solid = solid_of(box(0.25, 0.2, 0.35, 0.01), R)
    outward = R @ [0.0, 0.0, 1.0]
    assert max(float(cavity.direction @ outward) for cavity in containers(solid)) > 0.99


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_size_does_not_matter(size, tmp_path):
    solid = solid_of(box(0.25, 0.2, 0.35, 0.02), size=size)
    (opening,) = containers(solid)
    assert stays_inside(choose_colliders(solid, tmp_path).shapes, opening)


def test_a_ring_and_a_pipe_stay_open(tmp_path):
    for body in (Manifold.revolve(CrossSection.circle(0.02, 16).translate((0.08, 0)), 32),
                 Manifold.cylinder(0.2, 0.05, 0.05, 32) - Manifold.cylinder(0.2, 0.04, 0.04, 32)):  # fmt: skip
        solid = solid_of(body)
        assert [cavity.through for cavity in find_cavities(solid)] == [True]
        chosen = choose_colliders(solid, tmp_path)
        assert next(c for c in chosen.candidates if c.method == chosen.method).cavity_kept
