"""Choosing few out of many so that they lie far from one another."""

from __future__ import annotations

import numpy as np

from schemas.model import FloatArray


def spread(features: FloatArray, first: int, most: int, least: float) -> list[int]:
    """Indices of up to `most` rows of `features` (k, d), far from one another (at least `least`), from `first` on.

    Farthest-point sampling, Gonzalez 1985; of equals the earliest.
    """
    chosen = [first]
    apart = np.round(np.linalg.norm(features - features[first], axis=1), 9)
    while len(chosen) < most and apart.max() >= least:
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.round(np.linalg.norm(features - features[chosen[-1]], axis=1), 9))
    return chosen
