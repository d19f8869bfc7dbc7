"""Loss of each trial under parameters that the other trials taught, from one fit; tests between two models.

A trial pulls the parameters by one Newton step of its gradient; without it its loss is larger by twice what that step
took off (Takeuchi, 1976; to first order leave-one-out, and it stays finite where one trial alone knows a parameter).
Its start stays its own. Parameters at a bound do not move.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from schemas.arrays import FloatArray
from simgap.whole_trials.fit_model import ModelFit
from simgap.whole_trials.linearisation import solve_safely
from simgap.whole_trials.parameter_space import Space, vector_of


def held_out_losses(fit: ModelFit) -> FloatArray:
    """(t,) loss of each trial by values from the others."""
    space, vector = Space.of(fit.model), vector_of(fit.model)
    free = space.inside(vector)
    if not free.any():
        return fit.losses
    prior = np.diag((space.prior_precision * space.span**2)[free])
    information = fit.trial_information[:, free][:, :, free].sum(axis=0) + prior
    gradients = fit.gradients[:, free]
    steps = np.array([solve_safely(information, g) for g in gradients])
    return fit.losses + 2.0 * np.maximum((gradients * steps).sum(axis=1), 0.0)


def p_of_no_better(before: FloatArray, after: FloatArray, dispersion: float, degrees: int) -> float:
    """p-value that the model behind `after` is no better: (t,) losses of the same trials, held out.

    The smaller of two tests, doubled: that of a likelihood ratio with so many degrees of freedom, given the dispersion
    of the better model's errors, and Student's over trials. The first sees what few trials show clearly, the second
    what all trials show alike.
    """
    lead = float((before - after).sum()) / dispersion
    ratio = float(stats.chi2.sf(max(lead, 0.0), degrees))
    over_trials = 1.0
    changes = before - after
    if len(changes) > 2 and np.ptp(changes) > 1e-9:
        over_trials = float(np.asarray(stats.ttest_1samp(changes, 0.0, alternative="greater")[1]))
    return min(1.0, 2.0 * min(ratio, over_trials))
