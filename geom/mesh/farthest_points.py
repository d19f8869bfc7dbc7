"""Farthest-point sampling: a few rows of a feature array (k, d) that lie far from one another."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray


def farthest_points(features: FloatArray, first: int, most: int, least: float) -> list[int]:
    """Indices of up to `most` rows of `features` (k, d), far from one another (at least `least`), from `first` on.

    Source: Gonzalez 1985; among equal distances the earliest row is taken.
    """
    chosen = [first]
    apart = np.round(np.linalg.norm(features - features[first], axis=1), 9)
    while len(chosen) < most and apart.max() >= least:
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.round(np.linalg.norm(features - features[chosen[-1]], axis=1), 9))
    return chosen
