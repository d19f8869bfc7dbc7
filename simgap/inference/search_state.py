"""State of forward selection: base fit, problem with initial states taken there, error scale, training errors."""

from __future__ import annotations

from dataclasses import dataclass

from schemas.arrays import FloatArray
from simgap.inference.candidate_fit import warm_start
from simgap.inference.fit import Errors, Fit, fit, robust_scale, rollout_errors
from simgap.inference.losses import trial_losses
from simgap.problem import Model, Problem, View
from simgap.recording.train_test_split import Trials


@dataclass(frozen=True)
class SearchState:
    """A base model, and what fits of further effects on top of it need.

    problem   with initial states taken at the base model.
    scale     (c,) robust scale of the error per channel under that model, SI; errors and losses are in these units.
    errors    of the training trials.
    base      the model and its fit; accepted effects may have changed since.
    """

    problem: Problem
    trials: Trials
    view: View
    scale: FloatArray
    errors: Errors
    base: Fit

    def errors_at(self, model: Model) -> Errors:
        """Training errors with initial states taken at another model."""
        return rollout_errors(self.problem.with_initial_states_at(model), self.trials.train, self.view, self.scale)

    def test_losses(self, fitted: Fit) -> FloatArray:
        """(n,) losses of the test trials."""
        return trial_losses(self.problem.residuals(fitted.model, self.trials.test, self.view), self.scale)

    def test_losses_at_own_fit(self, fitted: Fit) -> FloatArray:
        """(n,) losses of the test trials, with initial states taken at the fit's own model."""
        problem_at_fit = self.problem.with_initial_states_at(fitted.model)
        return trial_losses(problem_at_fit.residuals(fitted.model, self.trials.test, self.view), self.scale)


def refit_at(problem: Problem, trials: Trials, view: View, base: Fit) -> SearchState:
    """The state at `base`, fitted again with initial states and error scale taken there.

    What was an outlier to a poor model is evidence to a better one: the scale follows the base.
    """
    problem_at_base = problem.with_initial_states_at(base.model)
    scale = robust_scale(problem_at_base, base.model, trials.train, view)
    errors = rollout_errors(problem_at_base, trials.train, view, scale)
    return SearchState(problem_at_base, trials, view, scale, errors, fit(errors, warm_start(base)))
