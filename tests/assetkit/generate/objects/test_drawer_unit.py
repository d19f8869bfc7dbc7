"""The drawer unit by hand: masses, insides and travel of its default parameters."""

from __future__ import annotations

import pytest

from assetkit.generate.objects.drawer_unit import GENERATOR, DrawerUnit
from assetkit.generate.write import truth_of

WOOD, STEEL = 650.0, 7850.0  # kg/m3, as the material table has them


def test_masses_and_insides_are_those_of_the_boards() -> None:
    (unit,) = GENERATOR.run(DrawerUnit(levels=2, width_m=0.4, depth_m=0.4, level_height_m=0.15, wall_m=0.01)).objects
    truth = truth_of(unit, "unit.urdf")
    masses = {link.name: link.mass_kg for link in truth.links}
    boards = 3 * 0.4 * 0.4 * 0.01
    sides = 2 * 2 * 0.4 * 0.15 * 0.01
    backs = 2 * 0.38 * 0.15 * 0.01
    assert masses["body"] == pytest.approx(WOOD * (boards + sides + backs))
    # 2 mm of gap: the box is 0.376 m wide, reaches from 12 mm behind the back to 2 mm in front of the case, and its
    # sides end 0.7 * 0.15 m above the level, 2 mm less below.
    length, width, height = 0.390, 0.376, 0.103
    box = length * width * 0.01 + (height - 0.01) * 0.01 * (2 * (length - 0.01) + width)
    front = 0.4 * (0.16 - 2 * 0.002) * 0.01
    handle = 0.012**2 * (0.12 + 2 * 0.03)
    assert masses["drawer_1"] == pytest.approx(WOOD * (box + front) + STEEL * handle)
    inside = (length - 0.01) * (width - 0.02) * (height - 0.01)
    assert [i.volume_m3 for i in truth.interiors] == pytest.approx([inside, inside])
    assert truth.joints[0].limits == pytest.approx((0.0, 0.8 * (length - 0.01)))
    assert truth.joints[0].axis == (1.0, 0.0, 0.0)
