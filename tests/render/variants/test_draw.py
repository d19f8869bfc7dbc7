"""Variants of one model: each surface is told apart in every view, and shows the material of the variant."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.materials.recovery.pictures import draw
from render.variants.regions import EMPTY, OTHER, region_rgb, regions_of
from schemas.appearance.material import Material
from tests.assetkit.materials.recovery.samples import box, model_of


def test_regions_come_back_from_their_colours_and_mixed_ones_are_empty() -> None:
    numbers = [OTHER, 0, 1, 31, 32, 500, 1023]
    pixels = np.array([[region_rgb(number) for number in numbers]])
    assert regions_of(pixels).tolist() == [numbers]
    assert regions_of(np.array([[(238, 238, 238), (4, 0, 255), (0, 128, 128)]])).tolist() == [[EMPTY] * 3]
    with pytest.raises(ValueError, match="1024"):
        region_rgb(1024)


def test_what_is_seen_of_each_surface(tmp_path: Path) -> None:
    """Red above blue, then the colours exchanged: the shares of colours follow the surface, not the picture."""
    red, blue = (Material("red", base_color=(0.6, 0.02, 0.02)), Material("blue", base_color=(0.02, 0.05, 0.6)))
    grey = Material("grey", base_color=(0.3, 0.3, 0.3))
    model = model_of([box("low", 0), box("high", 1, 0.11), box("aside", 2, 0.25)], [red, blue, grey])
    seen = draw(model, [(red, blue, grey), (blue, red, grey)], [0, 1], tmp_path)
    for variant, (first, second) in enumerate((("red", "blue"), ("blue", "red"))):
        low, high = seen[variant]
        assert low is not None
        assert high is not None
        assert low.colour_shares.get(first, 0.0) > 0.6 > low.colour_shares.get(second, 0.0)
        assert high.colour_shares.get(second, 0.0) > 0.6 > high.colour_shares.get(first, 0.0)
        assert low.neighbour_lab is not None
        assert low.neighbour_lab > 20.0


def test_a_hidden_surface_is_not_measured(tmp_path: Path) -> None:
    inner = replace(box("inner", 1), points=box("inner").points * 0.5)
    model = model_of([box("outer", 0), inner], [Material("a"), Material("b")])
    assert [drawn is None for drawn in draw(model, [model.materials], [0, 1], tmp_path)[0]] == [False, True]
