"""Where a search stands: a fitted model, the problem as seen from it, and how what is left is measured there."""

from __future__ import annotations

from dataclasses import dataclass

from schemas.model import FloatArray
from simgap.inference.candidate_fit import warm_start
from simgap.inference.fit import Errors, Fit, fit, robust_scale, rollout_errors
from simgap.inference.losses import trial_losses
from simgap.problem import Model, Problem, View, with_initial_states_at
from simgap.recording.train_test_split import Trials


@dataclass(frozen=True)
class SearchState:
    """A base model and what further effects are judged by beside it.

    problem   with what starts do taken at the model where the search came to stand here.
    level     (c,) typical error per channel of that model, SI; errors and losses are in these.
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
        """Errors of roll-outs whose starts are taken at another model."""
        return rollout_errors(with_initial_states_at(self.problem, model), self.trials.train, self.view, self.scale)

    def test_losses(self, fitted: Fit) -> FloatArray:
        """(n,) losses of the test trials."""
        return trial_losses(self.problem.residuals(fitted.model, self.trials.test, self.view), self.scale)

    def test_losses_at_own_fit(self, fitted: Fit) -> FloatArray:
        """(n,) losses of the test trials, seen from the fit's own model."""
        seen = with_initial_states_at(self.problem, fitted.model)
        return trial_losses(seen.residuals(fitted.model, self.trials.test, self.view), self.scale)


def refit_at(problem: Problem, trials: Trials, view: View, base: Fit) -> SearchState:
    """The search at `base`, which is fitted again there.

    What was an outlier to a poor model is evidence to a better one: the level follows the base.
    """
    state = with_initial_states_at(problem, base.model)
    scale = robust_scale(state, base.model, trials.train, view)
    errors = rollout_errors(state, trials.train, view, scale)
    return SearchState(state, trials, view, scale, errors, fit(errors, warm_start(base)))
