"""Insides of vessels: closed forms, laws, and walls that leak."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from manifold3d import CrossSection, Manifold, OpType

from geom.features.cavities import find_cavities
from geom.features.containment import Containment, find_containments
from schemas.physics import Solid
from tests.support.furniture import block, open_box, solid_of


def insides(solid: Solid) -> tuple[Containment, ...]:
    return find_containments(solid, find_cavities(solid))


@pytest.mark.parametrize("size", [1e-2, 1.0, 30.0])
def test_an_open_box_holds_a_b_h(size):
    (inside,) = insides(solid_of(open_box(0.4, 0.3, 0.2, 0.01), scale=size))
    assert inside.volume_m3 == pytest.approx(0.38 * 0.28 * 0.19 * size**3, rel=1e-6)
    assert inside.opening.symmetric_difference(shapely.box(-0.19, -0.14, 0.19, 0.14).buffer(0)).area < 1 or size != 1.0
    assert (inside.floor_m, inside.rim_m) == pytest.approx((0.01 * size, 0.2 * size), rel=1e-4)


def test_a_half_ball_holds_two_thirds_pi_r_cubed():
    bowl = (Manifold.sphere(0.1, 96) - Manifold.sphere(0.094, 96)).trim_by_plane((0, 0, -1), 0.0).translate((0, 0, 0.1))
    (inside,) = insides(solid_of(bowl))
    assert inside.volume_m3 == pytest.approx(2 / 3 * np.pi * 0.094**3, rel=0.02)
    areas = [layer.area for layer in inside.layers]
    assert areas == sorted(areas)


def test_a_bottle_is_wider_than_its_neck():
    outside = [(0, 0), (0.035, 0), (0.035, 0.12), (0.015, 0.16), (0.015, 0.2), (0.011, 0.2), (0.011, 0.16)]
    bottle = Manifold.revolve(CrossSection([np.array([*outside, (0.031, 0.12), (0.031, 0.004), (0, 0.004)])]), 48)
    (inside,) = insides(solid_of(bottle))
    cone = np.pi * 0.04 / 3 * (0.031**2 + 0.031 * 0.011 + 0.011**2)
    assert inside.volume_m3 == pytest.approx(np.pi * (0.031**2 * 0.116 + 0.011**2 * 0.04) + cone, rel=0.04)
    assert inside.opening.area == pytest.approx(np.pi * 0.011**2, rel=0.05)


@pytest.mark.parametrize("neck", [0.013, 0.022, 0.031])
def test_a_sharp_shoulder_between_two_layers_counts(neck: float):
    radius, mouth, height, wall = 0.034, 0.013, 0.13, 0.002
    outside = Manifold.cylinder(height, radius, radius, 96) + Manifold.cylinder(height + neck, mouth + wall, -1.0, 96)
    room = Manifold.cylinder(height - 2 * wall, radius - wall, radius - wall, 96).translate((0, 0, wall))
    room += Manifold.cylinder(neck + wall, mouth, mouth, 96).translate((0, 0, height - wall))
    (inside,) = insides(solid_of(outside - room))
    assert inside.volume_m3 == pytest.approx(room.volume(), rel=0.004)


def test_slots_in_the_walls_do_not_change_what_a_basket_holds():
    crate = open_box(0.4, 0.3, 0.2, 0.01)
    slots = [block(0.03, 0.5, 0.1, (0.07 * k, 0, 0.05)) for k in range(-2, 3)]
    (whole,), (basket,) = insides(solid_of(crate)), insides(solid_of(crate - Manifold.batch_boolean(slots, OpType.Add)))
    assert basket.volume_m3 == pytest.approx(whole.volume_m3, rel=0.03)


def test_under_slanting_walls_nothing_is_inside():
    def frustum(low: float, high: float, z: float) -> Manifold:
        return Manifold.extrude(CrossSection.square((low, low), True), z, scale_top=(high / low, high / low))

    tray = frustum(0.4, 0.6, 0.12) - frustum(0.385, 0.6, 0.12).translate((0, 0, 0.008))
    (inside,) = insides(solid_of(tray))
    slope = (0.6 - 0.385) / 0.12
    # Integral of the square's side over the height.
    side = np.linspace(0.385, 0.385 + slope * 0.112, 2001)
    assert inside.volume_m3 == pytest.approx(0.112 * float(np.mean(side**2)), rel=0.02)


def test_pipes_and_upturned_vessels_hold_nothing():
    pipe = Manifold.cylinder(0.2, 0.05, 0.05, 32) - Manifold.cylinder(0.2, 0.04, 0.04, 32)
    assert insides(solid_of(pipe)) == ()
    assert insides(solid_of(open_box(0.4, 0.3, 0.2, 0.01).rotate((180, 0, 0)))) == ()


def test_turning_about_the_vertical_turns_the_inside_along():
    turned = insides(solid_of(open_box(0.4, 0.3, 0.2, 0.01), yaw_rad=0.5))
    assert [i.volume_m3 for i in turned] == pytest.approx([0.38 * 0.28 * 0.19], rel=1e-5)


def test_a_sheet_holds_what_its_walls_leave():
    points = np.array([[x, y, z] for z in (0.0, 0.2) for y in (-0.15, 0.15) for x in (-0.2, 0.2)])
    quads = [(0, 2, 3, 1), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], dtype=np.int32)
    (inside,) = insides(Solid(points, triangles, "shell", wall_thickness_m=0.004))
    assert inside.volume_m3 == pytest.approx(0.396 * 0.296 * 0.198, rel=1e-3)
