"""Which input timing explains the trials: the null model fitted to pieces of trials at each timing that stamps allow.

From logs at the stamps, and nuisances, to the logs at the timing that is best beyond chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from simgap.kinds.mechanism.whole_trials import MechanismTrials
from simgap.kinds.mechanism.windowed_logs import WindowedLogs
from simgap.problem import Candidate, Term
from simgap.whole_trials.fit_model import ModelFit, fit_model
from simgap.whole_trials.held_out import p_of_no_better
from simgap.whole_trials.policy import POLICY

_TIMING_ALPHA = 0.01  # chance below which another input timing than the stamps is accepted
_PIECES = POLICY.pieces[0]  # short ones: what a model lacks builds up slowly, a wrong timing shows at once


def with_best_timing(logs: WindowedLogs, nuisances: Sequence[Candidate]) -> WindowedLogs:
    """The logs at the timing whose losses are significantly the smallest; as they are where none is."""
    if not logs.open_timings:
        return logs
    pieces = _pieces(logs)
    best, (losses, _) = logs, _null_losses(pieces, nuisances)
    for timing in logs.open_timings:
        other = logs.at_timing(timing)
        # Noise that smoothing shows differs with the stamps: losses are compared in levels of the same.
        theirs, dispersion = _null_losses(replace(_pieces(other), noise=pieces.noise), nuisances)
        if p_of_no_better(losses, theirs, dispersion, 1) < _TIMING_ALPHA and theirs.sum() < losses.sum():
            best, losses = other, theirs
    return best


def _pieces(logs: WindowedLogs) -> MechanismTrials:
    whole = MechanismTrials.of(logs.declared, logs.by_trial, tuple(logs.by_trial), logs.step_s)
    return whole.pieces(_PIECES) or whole


def _null_losses(pieces: MechanismTrials, nuisances: Sequence[Candidate]) -> tuple[FloatArray, float]:
    """Losses (t,) of the fitted null model, summed over the pieces of each trial, and their dispersion."""
    null = tuple(Term(c, dict(c.start)) for c in nuisances)
    still = np.zeros_like(pieces.start_steps)
    # The starts alone first: as far off as they are, they would move the nuisances.
    starts = fit_model(pieces, null, still, POLICY, fixed=True, iterations=POLICY.rung_iterations).starts
    fit: ModelFit = fit_model(pieces, null, starts, POLICY, iterations=POLICY.rung_iterations)
    trial = np.array([number for number, _ in pieces.piece_starts])
    return np.array([fit.losses[trial == k].sum() for k in range(len(pieces.trial_ids))]), fit.dispersion
