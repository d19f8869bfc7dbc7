"""Compartments that open sideways: their measures, and what is none because it is open elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from geom.features.cavities import find_cavities
from geom.features.side_compartments import find_side_compartments
from schemas.physics import Solid
from tests.support.mechanism.drawn_mechanisms import box, open_case, solid_of


def compartments(solid: Solid):
    return find_side_compartments(solid, find_cavities(solid))


def test_the_inside_of_a_case_is_measured() -> None:
    (inside,) = compartments(solid_of(open_case(0.6, 0.4, 0.5, 0.02)))
    assert inside.volume_m3 == pytest.approx(0.56 * 0.38 * 0.46, rel=0.02)
    assert inside.floor_m == pytest.approx(0.02, abs=1e-4)
    assert inside.rim_m == pytest.approx(0.48, abs=1e-4)
    assert inside.cavity.direction == pytest.approx([0.0, -1.0, 0.0])
    x0, y0, x1, y1 = inside.opening.bounds
    assert [x0, x1, y1] == pytest.approx([-0.28, 0.28, 0.18], abs=2e-3)
    assert y0 == pytest.approx(-0.2, abs=0.02), "as far as the plane of the opening"


def test_two_compartments_beside_each_other_are_two() -> None:
    divided = open_case(0.6, 0.4, 0.5, 0.02) + box((-0.01, -0.2, 0.0), (0.01, 0.2, 0.5))
    found = compartments(solid_of(divided))
    assert [c.volume_m3 for c in found] == pytest.approx([0.27 * 0.38 * 0.46] * 2, rel=0.03)
    assert {np.sign(c.opening.centroid.x) for c in found} == {-1.0, 1.0}


def test_without_a_side_wall_it_is_no_compartment() -> None:
    without = open_case(0.6, 0.4, 0.5, 0.02) - box((0.27, -0.3, 0.02), (0.4, 0.17, 0.48))
    assert compartments(solid_of(without)) == ()


def test_a_solid_block_has_none() -> None:
    assert compartments(solid_of(box((-0.3, -0.2, 0.0), (0.3, 0.2, 0.5)))) == ()
