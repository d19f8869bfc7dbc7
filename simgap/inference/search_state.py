"""State of forward selection: base fit, error scale there, errors of the training trials."""

from __future__ import annotations

from dataclasses import dataclass

from schemas.arrays import FloatArray
from simgap.inference.candidate_fit import warm_start
from simgap.inference.fit import Errors, Fit, fit, robust_scale, rollout_errors
from simgap.inference.losses import trial_losses
from simgap.problem import Problem
from simgap.recording.train_test_split import Trials


@dataclass(frozen=True)
class SearchState:
    """A base model, and what fits of further effects on top of it need.

    scale     (c,) robust scale of the error per channel under that model, SI; errors and losses are in these units.
    errors    of the training trials.
    base      the model and its fit; accepted effects may have changed since.
    """

    problem: Problem
    trials: Trials
    scale: FloatArray
    errors: Errors
    base: Fit

    def test_losses(self, fitted: Fit) -> FloatArray:
        """(n,) losses of the test trials."""
        return trial_losses(self.problem.residuals(fitted.model, self.trials.test, "short_horizon"), self.scale)


def refit_at(problem: Problem, trials: Trials, base: Fit) -> SearchState:
    """The state at `base`, fitted again with the error scale taken there.

    What was an outlier to a poor model is evidence to a better one: the scale follows the base.
    """
    scale = robust_scale(problem, base.model, trials.train)
    errors = rollout_errors(problem, trials.train, scale)
    return SearchState(problem, trials, scale, errors, fit(errors, warm_start(base)))
