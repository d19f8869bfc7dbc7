"""Black-box baseline: ridge regression of the residual on random Fourier features (Rahimi and Recht, NIPS 2007).

It is a rival for the gain, and the judge of "something is left": what it can predict on unseen trials is structure
that no accepted effect accounts for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.arrays import FloatArray

_FEATURES = 120
_REGRESSION_RIDGE = 1e-2


def corrected(
    train_features: Sequence[FloatArray],
    train_residuals: Sequence[FloatArray],
    test_features: Sequence[FloatArray],
    test_residuals: Sequence[FloatArray],
    seed: int = 0,
) -> list[FloatArray]:
    """Residuals (k, c) of the test trials minus what the training trials predict for them from features (k, f)."""
    X, Y = np.concatenate(train_features), np.concatenate(train_residuals)
    usable = np.isfinite(X).all(axis=1) & np.isfinite(Y).all(axis=1)
    X, Y = X[usable], Y[usable]
    centre, spread = X.mean(axis=0), X.std(axis=0) + 1e-12
    level = 1.4826 * np.median(np.abs(Y), axis=0) + 1e-15
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(X.shape[1], _FEATURES))
    shifts = rng.uniform(0.0, 2.0 * np.pi, _FEATURES)

    def lifted(x: FloatArray) -> FloatArray:
        z = (x - centre) / spread
        return np.concatenate([np.cos(z @ directions + shifts), z, np.sign(z), np.ones((len(z), 1))], axis=1)

    # Rare large errors must not decide what the many say.
    A, B = lifted(X), np.clip(Y / level, -6.0, 6.0)
    weights = np.linalg.solve(A.T @ A + _REGRESSION_RIDGE * len(A) * np.eye(A.shape[1]), A.T @ B)
    return [
        r - np.nan_to_num(lifted(np.nan_to_num(x)) @ weights) * level
        for x, r in zip(test_features, test_residuals, strict=True)
    ]
