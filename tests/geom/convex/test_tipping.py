"""Tipping by hand: boxes tip about the edge of their foot, spheres roll, a weighted round foot comes back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geom.convex.tipping import tipping_angle, tipping_loads
from geom.pose import DOWN
from schemas.physics import CollisionShape
from tests.support.sample_bodies import box, boxes, cylinder, sphere

LEAN = math.radians(5.0)


@pytest.mark.parametrize("height", [0.05, 0.2, 0.6])
def test_a_box_tips_when_its_centre_is_over_the_edge_of_its_foot(height: float) -> None:
    body = box((0.1, 0.3, height))
    angle, side = tipping_angle(body.shapes, np.asarray(body.mass.centre_of_mass_m), DOWN, LEAN)
    assert angle == pytest.approx(math.atan(0.1 / height), rel=0.01)
    assert abs(side) == pytest.approx([1.0, 0.0, 0.0], abs=0.05)


def test_an_off_centre_mass_tips_towards_itself() -> None:
    body = box((0.1, 0.1, 0.2))
    angle, side = tipping_angle(body.shapes, np.array([0.0, 0.03, 0.1]), DOWN, LEAN)
    assert angle == pytest.approx(math.atan(0.02 / 0.1), rel=0.03)
    assert side == pytest.approx([0.0, 1.0, 0.0], abs=0.05)


def test_a_cylinder_on_its_side_rolls_and_on_its_end_stands() -> None:
    body = cylinder(0.03, 0.1)
    centre = np.asarray(body.mass.centre_of_mass_m)
    assert tipping_angle(body.shapes, centre, DOWN, LEAN)[0] == pytest.approx(math.atan(0.03 / 0.05), rel=0.01)
    assert tipping_angle(body.shapes, centre, np.array([1.0, 0.0, 0.0]), LEAN)[0] == pytest.approx(0.0, abs=1e-6)


def test_a_round_foot_with_a_low_mass_centre_leans_and_holds() -> None:
    """A ball of radius R, mass centre b below the middle, leans by f where tan(tilt) = b sin f / (R - b cos f)."""
    ball = sphere(0.1)
    low = np.array([0.0, 0.0, 0.04])
    angle, _ = tipping_angle(ball.shapes, low, DOWN, LEAN)
    assert angle == pytest.approx(math.atan2(0.06 * math.sin(LEAN), 0.1 - 0.06 * math.cos(LEAN)), rel=0.1)
    assert tipping_angle(ball.shapes, np.array([0.0, 0.0, 0.11]), DOWN, LEAN)[0] < 0.0


def test_a_load_beside_the_foot_tips_by_the_law_of_the_lever() -> None:
    table = boxes([((0.1, 0.1, 0.4), (0.0, 0.0, 0.2)), ((0.5, 0.5, 0.02), (0.0, 0.0, 0.41))])
    centre, mass_kg = np.asarray(table.mass.centre_of_mass_m), table.mass.mass_kg
    at = np.array([[0.0, 0.0, 0.42], [0.04, 0.0, 0.42], [0.2, 0.0, 0.42], [0.0, -0.25, 0.42]])
    loads = tipping_loads(table.shapes, mass_kg, centre, DOWN, at)
    assert np.isinf(loads[:2]).all()
    assert loads[2:] == pytest.approx([mass_kg * 0.05 / 0.15, mass_kg * 0.05 / 0.2], rel=0.05)


def test_what_falls_over_alone_carries_nothing() -> None:
    shapes: tuple[CollisionShape, ...] = box((0.1, 0.1, 0.4)).shapes
    beside = np.array([[0.04, 0.0, 0.4], [0.2, 0.0, 0.4]])
    assert tipping_loads(shapes, 1.0, np.array([0.06, 0.0, 0.2]), DOWN, beside)[1] == 0.0
