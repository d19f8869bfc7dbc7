"""Instrumental-variable regression over trials as clusters: parameters, jackknife errors, p-value of the null."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from schemas.arrays import FloatArray
from simgap.problem import DirectEstimate

_LEAST_TRIALS = 4
_ROWS_PER_PARAMETER = 4
_OUTLIER = 6.0  # robust deviations from which on an equation is left out
_PASSES = 3


@dataclass(frozen=True)
class Equations:
    """Rows y (k,) = X (k, p) theta of one trial, with instruments Z (k, p).

    Instruments move with X but not with its noise; Z = X is plain least squares (Wald, Ann. Math. Stat. 11, 1940).
    """

    y: FloatArray
    X: FloatArray
    Z: FloatArray


def regress(trials: Sequence[Equations], names: Sequence[str], null: Mapping[str, float]) -> DirectEstimate | None:
    """The parameters with jackknife errors over trials, and the chance of `null`; None where the rows do not
    determine them.

    Outlying equations are left out of the fit.
    """
    used = [t for t in trials if len(t.y)]
    if len(used) < _LEAST_TRIALS or sum(len(t.y) for t in used) < _ROWS_PER_PARAMETER * len(names):
        return None
    theta, clean = _theta(used), used
    for _ in range(_PASSES):
        if theta is None:
            return None
        rest = [t.y - t.X @ theta for t in used]
        level = 1.4826 * np.median(np.abs(np.concatenate(rest))) + 1e-300
        inliers = [np.abs(r) <= _OUTLIER * level for r in rest]
        clean = [Equations(t.y[k], t.X[k], t.Z[k]) for t, k in zip(used, inliers, strict=True)]
        theta = _theta(clean)
    if theta is None:
        return None
    without = [_theta([*clean[:k], *clean[k + 1 :]]) for k in range(len(clean))]
    if any(w is None for w in without):
        return None
    n = len(clean)
    spread = np.array(without)
    errors = np.sqrt((n - 1) / n * ((spread - spread.mean(axis=0)) ** 2).sum(axis=0)) + 1e-15
    return DirectEstimate(
        dict(zip(names, theta.tolist(), strict=True)),
        dict(zip(names, errors.tolist(), strict=True)),
        _p_value(clean, np.array([null[name] for name in names])),
        n,
    )


def _p_value(trials: Sequence[Equations], null: FloatArray) -> float:
    """p-value of the null: its equations' errors are unrelated to the instruments, trial by trial (Hotelling's test).

    Put this way the answer does not depend on whether theta or 1 / theta is estimated (Anderson and Rubin, Ann. Math.
    Stat. 20, 1949).
    """
    scores = np.array([t.Z.T @ (t.y - t.X @ null) for t in trials])
    n, p = scores.shape
    if n <= p + 1:
        return 1.0
    mean, spread = scores.mean(axis=0), np.cov(scores.T).reshape(p, p)
    size = np.sqrt(np.outer(np.diag(spread), np.diag(spread))) + 1e-300
    root = np.sqrt(np.diag(spread)) + 1e-300
    squared = n * float((mean / root) @ np.linalg.pinv(spread / size) @ (mean / root))
    return float(stats.f.sf(squared * (n - p) / (p * (n - 1)), p, n - p))


def _theta(trials: Sequence[Equations]) -> FloatArray | None:
    """Instrumental-variable estimate (p,); None where the instruments do not move the regressors."""
    A = np.sum([t.Z.T @ t.X for t in trials], axis=0)
    b = np.sum([t.Z.T @ t.y for t in trials], axis=0)
    size = np.sqrt(np.outer(_squares([t.Z for t in trials]), _squares([t.X for t in trials]))) + 1e-300
    if np.linalg.cond(A / size) > 1e6:
        return None
    return np.linalg.solve(A, b)


def _squares(blocks: Sequence[FloatArray]) -> FloatArray:
    return np.sum([(b**2).sum(axis=0) for b in blocks], axis=0)
