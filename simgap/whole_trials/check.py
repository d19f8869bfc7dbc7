"""The whole-trial check of a model: what it leaves of whole trials, with every start free, against the noise.

Short horizons forgive what builds up slowly: a wrong cause may explain them as well as the right one. Over a whole
trial only a right model comes down to the noise. The model's parameters are fitted to the training trials once more;
the test trials teach it nothing but their own starts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.gap import Reason
from simgap.inference.decision import Decision, criterion, decide
from simgap.problem import Candidate, Model, Problem, Term
from simgap.whole_trials.fit_model import ModelFit, fit_model
from simgap.whole_trials.policy import Policy


@dataclass(frozen=True)
class WholeTrialCheck:
    """Mean square errors of test trials in noise levels, less one, of the null and of the final model.

    explains   kept where the final model comes down to the noise.
    """

    null_excess: float
    final_excess: float
    explains: Decision


def check_whole_trials(
    problem: Problem,
    model: Model,
    nuisances: Sequence[Candidate],
    train: Sequence[str],
    test: Sequence[str],
    policy: Policy,
) -> WholeTrialCheck | None:
    """The check of a final model; None for problems without whole trials."""
    null = tuple(Term(c, dict(c.start)) for c in nuisances)
    excesses = [_excess(problem, m, train, test, policy) for m in ((null, model) if model != null else (null,))]
    if any(e is None for e in excesses):
        return None
    before, after = float(excesses[0] or 0.0), float(excesses[-1] or 0.0)
    bound = policy.noise_excess + policy.explained * max(before, 0.0)
    test_of_noise = criterion("mean square error of whole test trials beyond the noise", after, "<=", bound)
    return WholeTrialCheck(before, after, decide([(Reason.LESS_THAN_UNEXPLAINED, test_of_noise)]))


def _excess(problem: Problem, model: Model, train: Sequence[str], test: Sequence[str], policy: Policy) -> float | None:
    system, judged = problem.whole_trials(train), problem.whole_trials(test)
    if system is None or judged is None:
        return None
    starts = fit_model(system, model, np.zeros_like(system.start_steps), policy, fixed=True).starts
    taught = fit_model(system, model, starts, policy)
    fit: ModelFit = fit_model(judged, taught.model, np.zeros_like(judged.start_steps), policy, fixed=True)
    return fit.excess
