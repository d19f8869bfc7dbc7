"""Generalised winding numbers of a triangle surface about points (k, 3)."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray


def winding_numbers(queries: FloatArray, corners: FloatArray) -> FloatArray:
    """Generalised winding number (k,) of the triangles `corners` (m, 3, 3) about each query (k, 3).

    1 inside a closed outward surface, 0 outside, fractional near openings. Source: Jacobson, Kavan, Sorkine-Hornung
    2013, "Robust inside-outside segmentation using generalized winding numbers", with the solid angle of van Oosterom
    and Strackee 1983. Cost is k times m.
    """
    return np.array([_winding(query, corners) for query in queries])


def _winding(query: FloatArray, corners: FloatArray) -> float:
    a, b, c = (corners[:, k] - query for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    triple = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = (
        la * lb * lc
        + np.einsum("ij,ij->i", a, b) * lc
        + np.einsum("ij,ij->i", b, c) * la
        + np.einsum("ij,ij->i", c, a) * lb
    )
    return float(np.arctan2(triple, below).sum() / (2.0 * np.pi))
