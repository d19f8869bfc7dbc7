"""FLIP between pictures, over the pixels of an object.

FLIP: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A Difference Evaluator for
Alternating Images"; the library is that of its authors (`flip-evaluator`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import flip_evaluator
import numpy as np

from benchmarks.appearance.cycles import Picture
from schemas.arrays import BoolArray, Float32Array

PIXELS_PER_DEGREE = 67.0  # The default of the authors: a 4k screen 0.7 m wide, seen from 0.7 m.


def mean_flip(first: Mapping[str, Picture], second: Mapping[str, Picture]) -> dict[str, float]:
    """Mean FLIP by view over the pixels that the object touches in either picture; 1 where both are empty."""
    means: dict[str, float] = {}
    for view, picture in first.items():
        pixels = covered(picture, second[view])
        values = flip_map(picture.rgb, second[view].rgb)[pixels]
        means[view] = round(float(values.mean()), 4) if len(values) else 1.0
    return means


def covered(first: Picture, second: Picture) -> BoolArray:
    """(h, w) the pixels that the object touches in either picture."""
    return (first.alpha > 0.0) | (second.alpha > 0.0)


def flip_map(reference: Float32Array, test: Float32Array) -> Float32Array:
    """(h, w) FLIP, 0 to 1, between two sRGB pictures (h, w, 3)."""
    first, second = (np.ascontiguousarray(picture, dtype=np.float32) for picture in (reference, test))
    answer: Any = flip_evaluator.evaluate(
        first, second, "LDR", applyMagma=False, computeMeanError=False, parameters={"ppd": PIXELS_PER_DEGREE}
    )
    return np.asarray(answer[0], dtype=np.float32)[..., 0]
