"""Duplicate faces and closed shells of a triangle mesh: which faces (m,) repeat others at the same place."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from geom.mesh.components import Components
from schemas.arrays import BoolArray, FloatArray, IntArray

# Copies may differ by export rounding: this share of the shell's own diagonal.
COPY_TOLERANCE = 1e-4
# A component is drawn double-sided on purpose where this share of its faces has a reverse: half as many are the copies.
DOUBLE_SIDED_SHARE = 0.8


def surplus_shells(points: FloatArray, triangles: IntArray, parts: Components) -> tuple[int, BoolArray]:
    """Number of surplus copies of closed shells, and a mask (m,) of their faces; the first copy stays.

    Two cases: copies whose points were welded, so that every face of a closed component occurs k times, wound the same
    way; and separate closed components whose points coincide within 1e-4 of their diagonal and whose volumes have the
    same sign. A shell and its reverse (drawn for double-sided rendering) are not copies.
    """
    welded_count, welded = _welded_copies(triangles, parts)
    apart = _separate_copies(points, triangles, parts)
    return welded_count + int(apart.sum()), welded | apart[parts.label]


def later_copies(keys: IntArray) -> BoolArray:
    """(m,) True where an earlier row of `keys` (m, k) is equal."""
    later = np.ones(len(keys), dtype=bool)
    later[np.unique(row_numbers(keys), return_index=True)[1]] = False
    return later


def oriented_keys(triangles: IntArray) -> IntArray:
    """Each face (m, 3) rotated so that its smallest index comes first; equal rows are equal faces of equal winding."""
    turn = triangles.argmin(axis=1)[:, None] + np.arange(3)
    return np.take_along_axis(triangles, turn % 3, axis=1)


def has_reverse(triangles: IntArray) -> BoolArray:
    """(m,) True for faces whose reverse, the same points in opposite winding, is also among them."""
    both = row_numbers(np.concatenate([oriented_keys(triangles), oriented_keys(triangles[:, [0, 2, 1]])]))
    forward, reverse = np.split(both, 2)
    return np.isin(reverse, forward)


def row_numbers(rows: IntArray) -> IntArray:
    """(m,) int64, equal where the rows (m, 3) of non-negative indices are equal; one number per row sorts fast."""
    base = int(rows.max(initial=0)) + 1
    if base > 2**21:  # Three indices no longer fit into 63 bits.
        return np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1)
    a, b, c = rows.astype(np.int64).T
    return (a * base + b) * base + c


def _welded_copies(triangles: IntArray, parts: Components) -> tuple[int, BoolArray]:
    later = later_copies(oriented_keys(triangles))
    extra = np.bincount(parts.label[later], minlength=parts.count)
    first = parts.faces - extra
    whole = parts.closed & (extra > 0) & (extra % np.maximum(first, 1) == 0)
    return int((extra // np.maximum(first, 1))[whole].sum()), later & whole[parts.label]


def _separate_copies(points: FloatArray, triangles: IntArray, parts: Components) -> BoolArray:
    surplus = np.zeros(parts.count, dtype=bool)
    solids = np.flatnonzero(parts.solid)
    tolerance = COPY_TOLERANCE * parts.extent
    if len(solids) < 2:
        return surplus
    boxes = np.concatenate([parts.low, parts.high], axis=1)
    boxes = boxes - boxes[solids].mean(axis=0)  # Far from the origin the tree would compare rounded squares.
    near = KDTree(boxes[solids]).query_pairs(tolerance[solids].max(), p=np.inf, output_type="ndarray")
    pairs = solids[near[np.lexsort((near[:, 1], near[:, 0]))]]
    first, other = pairs.T
    alike = (
        (np.abs(boxes[other] - boxes[first]).max(axis=1, initial=0.0) <= tolerance[first])
        & (parts.volume[other] * parts.volume[first] > 0.0)
        & (np.abs(parts.area[other] - parts.area[first]) <= 1e-3 * parts.area[first])
    )
    for first, other in pairs[alike]:
        if surplus[first] or surplus[other]:
            continue
        mine, theirs = (points[np.unique(triangles[parts.label == part])] for part in (first, other))
        apart = max(KDTree(mine).query(theirs)[0].max(), KDTree(theirs).query(mine)[0].max())
        surplus[other] = bool(apart <= tolerance[first])
    return surplus
