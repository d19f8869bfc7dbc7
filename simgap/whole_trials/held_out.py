"""Deviance of each trial under parameters that the other trials taught, from one fit.

Leaving out a trial moves the parameters by one Newton step; its start stays its own. Exact for errors that are linear
in the parameters (Cook, Technometrics 19, 1977; for roll-outs to second order). Losses of two models are compared
trial by trial, on logarithms, so that violent trials do not outvote the others.
"""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from simgap.inference.losses import paired_p
from simgap.whole_trials.fit_model import ModelFit, Space, solve_safely


def held_out_deviance(fit: ModelFit) -> FloatArray:
    """(t,) deviance of each trial by values from the others."""
    space = Space.of(fit.model)
    out = fit.deviance.copy()
    if not len(space.low):
        return out
    prior = np.diag(space.prior_precision * space.span**2)
    total = fit.trial_information.sum(axis=0) + prior
    for t, (information, gradient) in enumerate(zip(fit.trial_information, fit.gradients, strict=True)):
        moved = solve_safely(total - information, gradient)
        out[t] += max(0.0, float(2.0 * gradient @ moved + moved @ information @ moved))
    return out


def p_of_no_better(before: FloatArray, after: FloatArray) -> float:
    """One-sided p-value that `after` is not smaller than `before`, both (t,) deviances of the same trials."""
    return paired_p(before, after) if len(before) > 1 else 1.0
