"""Least squares by segments: shared values with priors, and starts that belong to one segment each.

Errors and columns come by segment; the starts are eliminated within their segment.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tests.suites.gap2.generate.arrays import Array

TOLERANCE = 0.02  # of believed numbers, one standard deviation: controls are up to 3 % off

Columns = Sequence[Sequence[Array]]  # by segment, then by value


def _free_of_starts(by_start: Columns, values: Sequence[Array]) -> Array:
    """Values by segment, each without what its own start explains, in one array."""
    out = []
    for columns, value in zip(by_start, values, strict=True):
        Q = np.linalg.qr(np.stack(columns, axis=1))[0]
        out.append(value - Q @ (Q.T @ value))
    return np.concatenate(out)


def without_nuisances(at: Sequence[Array], shares: Array, shared: Columns, by_start: Columns) -> tuple[Array, Array]:
    """The errors without starts and nuisances, and an orthonormal basis of the nuisances; priors are the last rows."""
    count = len(shares)
    columns = [
        np.concatenate([_free_of_starts(by_start, [c[k] for c in shared]), (np.arange(count) == k) / TOLERANCE])
        for k in range(count)
    ]
    basis = np.linalg.qr(np.stack(columns, axis=1))[0]
    signal = np.concatenate([_free_of_starts(by_start, at), shares / TOLERANCE])
    return signal - basis @ (basis.T @ signal), basis


def without_basis(by_start: Columns, values: Sequence[Array], basis: Array) -> Array:
    """Values by segment without starts and nuisances, in one array."""
    value = np.concatenate([_free_of_starts(by_start, values), np.zeros(basis.shape[1])])
    return value - basis @ (basis.T @ value)


def gauss_newton(
    shared: Columns, by_start: Columns, at: Sequence[Array], shares: Array, count: int
) -> tuple[Array, list[Array]]:
    """Step of the shared values and of each segment's start (in its own sizes)."""
    total = len(shared[0])
    rows, right = [], []
    for columns, starts, error in zip(shared, by_start, at, strict=True):
        Q = np.linalg.qr(np.stack(starts, axis=1))[0]
        J = np.stack(columns, axis=1) if total else np.zeros((len(error), 0))
        rows.append(J - Q @ (Q.T @ J))
        right.append(-(error - Q @ (Q.T @ error)))
    prior = np.zeros((total - count, total))
    prior[:, count:] = np.eye(total - count) / TOLERANCE
    J, b = np.concatenate([*rows, prior]), np.concatenate([*right, -shares / TOLERANCE])
    step = np.linalg.lstsq(J, b, rcond=1e-9)[0] if total else np.zeros(0)
    moves = []
    for columns, starts, error in zip(shared, by_start, at, strict=True):
        reached = error + (np.stack(columns, axis=1) @ step if total else 0.0)
        moves.append(np.linalg.lstsq(np.stack(starts, axis=1), -reached, rcond=1e-9)[0])
    return step, moves
