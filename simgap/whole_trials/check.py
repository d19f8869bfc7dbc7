"""The whole-trial check of models: what they leave of trials that taught them nothing but their starts.

Short horizons forgive what builds up slowly: a wrong cause may explain them as well as the right one. Over a whole
trial only a right model comes down to the noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Criterion, Reason
from simgap.inference.decision import Decision, criterion, decide
from simgap.problem import Model, TrialSystem
from simgap.whole_trials.fit_model import ModelFit
from simgap.whole_trials.ladder import starts_on
from simgap.whole_trials.policy import Policy
from simgap.whole_trials.search_models import ModelSearch


@dataclass(frozen=True)
class WholeTrialCheck:
    """Mean square errors (t,) of test trials under the null and under the final model, in noise levels.

    explains   kept where the final model comes down to the noise.
    """

    null: FloatArray
    final: FloatArray
    explains: Decision


def check_whole_trials(
    system: TrialSystem, null: Model, final: Model, taught: tuple[ModelFit, ModelFit], policy: Policy
) -> WholeTrialCheck:
    """The check of fitted models on test trials, with the noise that the final model's errors show.

    Its fits `taught` (null and final) must explain the trials that taught them, too: a cause may act in few trials.
    """
    after = starts_on(system, final, policy)
    system = system.with_noise_from(final, after.starts)
    before, after = (starts_on(system, model, policy) for model in (null, final))
    explains = decide(
        [
            (Reason.LESS_THAN_UNEXPLAINED, _comes_down("test", before, after, policy)),
            (Reason.LESS_THAN_UNEXPLAINED, _comes_down("training", *taught, policy)),
        ]
    )
    return WholeTrialCheck(_mean_squares(before), _mean_squares(after), explains)


def confirmed(system: TrialSystem, search: ModelSearch, policy: Policy) -> ModelSearch:
    """The search up to the first effect with which the test trials do worse: they have the last word.

    Trials that an effect does not reach do neither better nor worse.
    """
    fits = [starts_on(system, model.fit.model, policy) for model in search.sizes]
    for size, (before, after) in enumerate(pairwise(fits)):
        # Losses are logarithms: of the mean over trials of one plus the mean square error.
        ratio = float(np.exp(0.5 * (after.losses - before.losses).sum() / after.rows.sum()))
        test = criterion("ratio of test losses, whole trials", ratio, "<", np.exp(0.5 * policy.least_lead))
        if not test.holds:
            return search.up_to(size, decide([(Reason.TEST_TRIALS_WORSE, test)]))
    return search


def _comes_down(which: str, before: ModelFit, after: ModelFit, policy: Policy) -> Criterion:
    """Whether the excess over noise does, of all of these trials together and but for a share of that before."""
    was, now = (float(np.minimum(_mean_squares(f) - 1.0, policy.largest_excess).mean()) for f in (before, after))
    uncertain = policy.noise_errors * 2.0 / np.sqrt(after.rows.sum())
    bound = policy.noise_excess + uncertain + policy.explained * max(was, 0.0)
    return criterion(f"mean square error of whole {which} trials beyond the noise", now, "<=", bound)


def _mean_squares(fit: ModelFit) -> FloatArray:
    return fit.deviance / fit.rows
