"""Rooms behind a neck are found whichever way it looks; the colliders of such vessels let the ball in and hold it."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold
from scipy.spatial.transform import Rotation

from assetkit.colliders.choose import choose_colliders
from geom.features.cavities import find_cavities
from tests.assetkit.colliders.test_choose_keeps_openings import solid_of
from tests.support.probe_drop import stays_inside

ASKEW = Rotation.from_euler("xyz", [33.0, 20.0, 10.0], degrees=True).as_matrix()
UP_IS_Y = Rotation.from_euler("x", -90.0, degrees=True).as_matrix()


def turned(outer: list[tuple[float, float]], inner: list[tuple[float, float]]) -> Manifold:
    return Manifold.revolve(CrossSection([np.array([*outer, *inner])]), 24)


def bottle() -> Manifold:
    inner = [(0.012, 0.1805), (0.033, 0.1505), (0.033, 0.002), (0.0, 0.002)]
    return turned([(0, 0), (0.035, 0), (0.035, 0.15), (0.014, 0.18), (0.014, 0.21), (0.012, 0.21)], inner)


def thick() -> Manifold:
    inner = [(0.012, 0.15), (0.03, 0.12), (0.03, 0.01), (0.0, 0.01)]
    return turned([(0, 0), (0.04, 0), (0.04, 0.12), (0.022, 0.15), (0.022, 0.18), (0.012, 0.18)], inner)


def jar() -> Manifold:
    inner = [(0.031, 0.115), (0.046, 0.1), (0.046, 0.004), (0.0, 0.004)]
    return turned([(0, 0), (0.05, 0), (0.05, 0.1), (0.035, 0.115), (0.035, 0.13), (0.031, 0.13)], inner)


def tank(neck: Manifold, bore: Manifold, wall: float = 0.003) -> Manifold:
    inside = Manifold.cylinder(0.1 - 2 * wall, 0.045 - wall, 0.045 - wall, 24).translate((0, 0, wall))
    return Manifold.cylinder(0.1, 0.045, 0.045, 24) + neck - inside - bore


def off_centre() -> Manifold:
    pipe = [Manifold.cylinder(h, r, r, 24).translate((0.024, 0, 0.05)) for r, h in ((0.018, 0.08), (0.015, 0.1))]
    return tank(pipe[0], pipe[1])


def leaning_neck() -> Manifold:
    sizes = ((0.017, 0.06), (0.014, 0.08))
    lean = [Manifold.cylinder(h, r, r, 24).rotate((0, 30, 0)).translate((0, 0, 0.09)) for r, h in sizes]
    return tank(lean[0], lean[1])


def can() -> Manifold:
    return tank(Manifold(), Manifold.cylinder(0.1, 0.012, 0.012, 24).translate((0.015, 0, 0.05)), 0.001)


# Mouth radius, and the axis of the neck.
MOUTHS = {
    "bottle": (bottle, 0.012, (0, 0, 1)),
    "thick bottle": (thick, 0.012, (0, 0, 1)),
    "jar with shoulders": (jar, 0.031, (0, 0, 1)),
    "mouth off centre": (off_centre, 0.015, (0, 0, 1)),
    "leaning neck": (leaning_neck, 0.014, (0.5, 0, np.sqrt(0.75))),
    "can with a hole": (can, 0.012, (0, 0, 1)),
}


@pytest.mark.parametrize(("name", "size"), [*((name, 1.0) for name in MOUTHS), ("jar with shoulders", 1000.0)])
def test_the_mouth_has_its_width_and_looks_its_way(name, size):
    make, radius, axis = MOUTHS[name]
    found = [c for c in find_cavities(solid_of(make(), ASKEW, size)) if not c.through]
    assert len(found) == 1
    assert found[0].diameter_m / size == pytest.approx(2.0 * radius, rel=0.1)
    assert found[0].direction @ ASKEW @ axis > np.cos(np.radians(8.0))
    # The ball's way leads through the mouth and deep inside, clear of all walls.
    assert found[0].depth_m > 0.09 * size


@pytest.mark.parametrize(("name", "R"), [("bottle", UP_IS_Y), ("can with a hole", np.eye(3))])
def test_the_ball_goes_in_and_stays(name, R, tmp_path):
    solid = solid_of(MOUTHS[name][0](), R)
    chosen = choose_colliders(solid, tmp_path)
    (opening,) = (c for c in chosen.cavities if not c.through)
    assert next(c for c in chosen.candidates if c.method == chosen.method).accepted
    assert stays_inside(chosen.shapes, opening)


def test_frames_and_pinholes_are_no_mouths():
    beam = [Manifold.cube((0.3, 0.02, 0.02)), Manifold.cube((0.02, 0.3, 0.02)), Manifold.cube((0.02, 0.02, 0.3))]
    cage = Manifold()
    for x, y in [(0, 0), (0, 0.28), (0.28, 0), (0.28, 0.28)]:
        places = [(0, x, y), (x, 0, y), (x, y, 0)]
        cage = cage + beam[0].translate(places[0]) + beam[1].translate(places[1]) + beam[2].translate(places[2])
    assert not [c for c in find_cavities(solid_of(cage)) if not c.through]
    pin = tank(Manifold(), Manifold.cylinder(0.1, 0.002, 0.002, 16).translate((0.015, 0, 0.05)))
    assert find_cavities(solid_of(pin)) == ()
