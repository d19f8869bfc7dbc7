"""The whole-trial check of models: what they leave of trials that taught them nothing but their starts.

Short horizons forgive what builds up slowly: a wrong cause may explain them as well as the right one. Over a whole
trial only a right model comes down to the noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.gap import Reason
from simgap.inference.decision import Decision, criterion, decide
from simgap.problem import Model, TrialSystem
from simgap.whole_trials.fit_model import ModelFit
from simgap.whole_trials.ladder import starts_on
from simgap.whole_trials.policy import Policy


@dataclass(frozen=True)
class WholeTrialCheck:
    """Mean square errors (t,) of test trials under the null and under the final model, in noise levels.

    explains   kept where the final model comes down to the noise.
    """

    null: FloatArray
    final: FloatArray
    explains: Decision


def check_whole_trials(system: TrialSystem, null: Model, final: Model, policy: Policy) -> WholeTrialCheck:
    """The check of fitted models on a system of test trials, with the noise that the final model's errors show."""
    after = starts_on(system, final, policy)
    system = system.with_noise_from(final, after.starts)
    before, after = (starts_on(system, model, policy) for model in (null, final))
    # What all are to tell, none may drown: beyond this many noise levels a trial is off, and how far is no matter.
    most = policy.largest_excess
    excess_before, excess_after = (float(np.minimum(_mean_squares(f) - 1.0, most).mean()) for f in (before, after))
    bound = policy.noise_excess + policy.explained * max(excess_before, 0.0)
    test_of_noise = criterion("mean square error of whole test trials beyond the noise", excess_after, "<=", bound)
    explains = decide([(Reason.LESS_THAN_UNEXPLAINED, test_of_noise)])
    return WholeTrialCheck(_mean_squares(before), _mean_squares(after), explains)


def _mean_squares(fit: ModelFit) -> FloatArray:
    return fit.deviance / fit.rows
