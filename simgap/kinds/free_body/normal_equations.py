"""Normal equations of one toss about some parameters, from values or from rows of a linear model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray


@dataclass(frozen=True)
class NormalEquations:
    """Normal equations H (k, k), g (k,) of least squares about numbers relative to `origin` (k,)."""

    H: FloatArray
    g: FloatArray
    origin: FloatArray


def of_values(values: FloatArray, origin: float = 0.0) -> NormalEquations | None:
    """One number seen as `values` (n,): their median, as sure as the first few of them make it."""
    if not len(values):
        return None
    weight = min(float(len(values)), 4.0)
    return NormalEquations(np.array([[weight]]), np.array([weight * (np.median(values) - origin)]), np.array([origin]))


def of_rows(design: FloatArray, seen: FloatArray, origin: FloatArray) -> NormalEquations:
    """`design` (n, k) times the numbers, less their origin, equals `seen` (n,)."""
    return NormalEquations(design.T @ design, design.T @ seen, origin)
