"""Figures of the comparison: FLIP over the object alone, targets of views and medians, glass apart, refusals named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.appearance.cycles import Picture
from benchmarks.appearance.flip import mean_flip
from benchmarks.appearance.table import Comparison, Refusal, table
from schemas.arrays import Float32Array

VIEWS = ("view_front", "view_left", "view_back", "view_top")


def _row(name: str, *flips: float, apart: bool = False) -> Comparison:
    by_view: dict[str, float] = dict(zip(VIEWS, flips, strict=True))
    return Comparison(name, "accepted", apart, ("sheen.color",), by_view, {"view_front": 0.03}, by_view, by_view)


def _picture(colour: float, alpha: Float32Array) -> Picture:
    rgb = np.full((32, 32, 3), 0.5, dtype=np.float32)
    rgb[alpha > 0.0] = colour
    return Picture(rgb, alpha)


def test_flip_is_a_mean_over_the_pixels_that_the_object_touches_in_either_picture():
    left, right = np.zeros((2, 32, 32), dtype=np.float32)
    left[:, :16], right[:, 16:] = 1.0, 1.0
    black, white = _picture(0.0, left), _picture(1.0, left)
    assert mean_flip({"v": black}, {"v": black}) == {"v": 0.0}
    assert mean_flip({"v": black}, {"v": white})["v"] > 0.9
    # Half of the union differs as strongly as before, the other half not at all.
    wide = Picture(white.rgb, np.ones((32, 32), dtype=np.float32))
    assert 0.4 < mean_flip({"v": replace(black, alpha=right)}, {"v": wide})["v"] < 0.6
    nothing = Picture(black.rgb, np.zeros((32, 32), dtype=np.float32))
    assert mean_flip({"v": nothing}, {"v": nothing}) == {"v": 1.0}


def test_a_sample_fails_by_its_worst_view_and_the_median_is_over_means_of_samples():
    rows = [
        _row("good", 0.01, 0.01, 0.01, 0.01),
        _row("edge", 0.1, 0.02, 0.02, 0.02),
        _row("bad", 0.0, 0.0, 0.0, 0.101),
    ]
    assert [row.meets for row in rows] == [True, True, False]
    text = table([*rows, _row("glass", 0.5, 0.5, 0.5, 0.5, apart=True), Refusal("broken", "0 packages")])
    surfaces, apart = text.split("### Glass and clear coats")
    assert "2 of 3 samples" in surfaces
    assert "median over samples 0.025" in surfaces
    assert "Above: bad." in surfaces
    assert "**0.101**" in surfaces
    assert "glass" not in surfaces
    assert "0 of 1 samples" in apart
    assert "broken was not compared: 0 packages" in apart
