"""Farthest-point sampling: a few rows of a feature array (k, d) that lie far from one another."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray


def farthest_points(features: FloatArray, first: int, most: int, least: float) -> list[int]:
    """Indices of up to `most` rows of `features` (k, d), far from one another (at least `least`), from `first` on.

    Source: Gonzalez 1985; among equal distances the earliest row is taken.
    """
    chosen = [first]
    apart = _rounded_distances(features, first)
    while len(chosen) < most and apart.max() >= least:
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, _rounded_distances(features, chosen[-1]))
    return chosen


def _rounded_distances(features: FloatArray, row: int) -> FloatArray:
    distances: FloatArray = np.linalg.norm(features - features[row], axis=1)
    return distances.round(9)
