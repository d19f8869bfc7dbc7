"""Cups nest: one put `nesting step` higher into another touches it and does not overlap."""

from __future__ import annotations

import numpy as np
import pytest

from assetkit.generate.objects.stackable_cup import GENERATOR
from assetkit.generate.parameters import random_parameters


@pytest.mark.parametrize("seed", range(4))
def test_a_cup_stands_in_another_one_at_the_nesting_step(seed: int) -> None:
    generated = GENERATOR.run(random_parameters(GENERATOR.parameters, np.random.default_rng(seed)))
    cup = generated.objects[0].links[0].parts[0].shape.solid
    step = generated.clearances[0].clearance_m
    above = cup.translate((0.0, 0.0, step + 1e-6))
    assert (cup ^ above).volume() <= 1e-12
    lower = cup.translate((0.0, 0.0, 0.9 * step))
    assert (cup ^ lower).volume() > 1e-9


def test_the_inside_is_a_frustum() -> None:
    (cup,) = GENERATOR.run().objects
    p = GENERATOR.parameters()
    top = p.radius_m - p.wall_m
    bottom = top - (p.height_m - p.wall_m) * np.tan(p.draft_rad)
    volume = np.pi / 3.0 * (p.height_m - p.wall_m) * (top**2 + top * bottom + bottom**2)
    assert cup.interiors[0].volume_m3 == pytest.approx(volume, rel=1e-3)  # 96 corners: 0.07 %
