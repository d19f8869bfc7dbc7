"""Which models explain the trials: the null, then models of one, two, three effects, each grown from the best before.

From candidates and a system of trials to fitted models by size. Every size is screened by score tests; the promising
candidates are fitted to the end. A size is entered only where its best model is significantly and noticeably better
than the best of the size before, on trials that taught it nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.gap import Reason
from simgap.inference.decision import Decision, criterion, decide
from simgap.problem import Candidate, Model, Term, TrialSystem
from simgap.whole_trials.fit_model import ModelFit, fit_model, linearise
from simgap.whole_trials.held_out import held_out_deviance, p_of_no_better
from simgap.whole_trials.policy import Policy
from simgap.whole_trials.score_test import Score, scores

_LEAST_SCORE = 8.0  # deviance below which a linear step is noise: 99.5 % of chi-squared with one degree


@dataclass(frozen=True)
class FittedModel:
    """A model with its deviance on trials that taught it nothing (t,)."""

    fit: ModelFit
    held_out: FloatArray

    @property
    def order(self) -> tuple[float, tuple[str, ...]]:
        """Best first; names decide ties."""
        return float(self.held_out.sum()), tuple(sorted(self.fit.keys))


@dataclass(frozen=True)
class Growth:
    """One step of the search: models of one size, best first, the scores behind them, and whether it was entered."""

    models: tuple[FittedModel, ...]
    scores: tuple[Score, ...]
    entered: Decision


@dataclass(frozen=True)
class ModelSearch:
    """The null model and the steps of the search."""

    null: FittedModel
    growths: tuple[Growth, ...]

    @property
    def size(self) -> int:
        """Effects of the chosen model."""
        return sum(g.entered.kept for g in self.growths)

    @property
    def chosen(self) -> FittedModel:
        """The best model of the last size that was entered."""
        return self.growths[self.size - 1].models[0] if self.size else self.null


def search_models(
    system: TrialSystem,
    candidates: Sequence[Candidate],
    nuisances: Sequence[Candidate],
    policy: Policy,
    most: int | None = None,
) -> ModelSearch:
    """Models of at most `most` effects (0: the null alone)."""
    null = null_model(system, nuisances, policy)
    last, growths = [null], []
    for _ in range(policy.most_effects if most is None else most):
        growth = _grow(system, last, candidates, policy)
        if growth is None:
            break
        growths.append(growth)
        if not growth.entered.kept:
            break
        last = list(growth.models)
    return ModelSearch(null, tuple(growths))


def null_model(system: TrialSystem, nuisances: Sequence[Candidate], policy: Policy) -> FittedModel:
    """The declared model with its nuisances and all starts fitted."""
    model = tuple(Term(c, dict(c.start)) for c in nuisances)
    starts = np.zeros_like(system.start_steps)
    # The starts alone first: as far off as they are, they would move the nuisances.
    starts = fit_model(system, model, starts, policy, fixed=True).starts
    return _fitted(fit_model(system, model, starts, policy))


def _fitted(fit: ModelFit) -> FittedModel:
    return FittedModel(fit, held_out_deviance(fit))


def _grow(
    system: TrialSystem, parents: Sequence[FittedModel], candidates: Sequence[Candidate], policy: Policy
) -> Growth | None:
    models: dict[frozenset[str], FittedModel] = {}
    first: tuple[Score, ...] = ()
    for parent in parents[: policy.beam]:
        linear = linearise(system, parent.fit.model, parent.fit.starts)
        ranked = scores(system, parent.fit, linear, [c for c in candidates if c.key not in parent.fit.keys])
        first = first or ranked
        enough = max(_LEAST_SCORE, policy.promising * ranked[0].reduction) if ranked else np.inf
        for score in [s for s in ranked if s.reduction >= enough][: policy.full_fits]:
            keys = parent.fit.keys | {score.candidate.key}
            if keys not in models:
                models[keys] = _fitted(extended(system, parent.fit, score, policy))
    if not models:
        return None
    ordered = tuple(sorted(models.values(), key=lambda m: m.order))
    return Growth(ordered, first, _enters(parents[0], ordered[0], len(candidates), policy))


def extended(system: TrialSystem, parent: ModelFit, score: Score, policy: Policy) -> ModelFit:
    """A model with a further effect, fitted from the better of its beginnings."""
    begun = [
        fit_model(system, _added(parent.model, score.candidate, values), parent.starts, policy, iterations=2)
        for values in score.begins
    ]
    best = min(begun, key=lambda f: float(f.deviance.sum()))
    return fit_model(system, best.model, best.starts, policy)


def _added(model: Model, candidate: Candidate, values: dict[str, float]) -> Model:
    return (*model, Term(candidate, values))


def _enters(before: FittedModel, after: FittedModel, candidates: int, policy: Policy) -> Decision:
    """Kept if the larger model is significantly and noticeably better on trials that taught it nothing."""
    p_value = min(1.0, candidates * p_of_no_better(before.held_out, after.held_out))
    gain = 1.0 - after.held_out.sum() / max(before.held_out.sum(), 1e-12)
    return decide(
        [
            (
                Reason.TOO_SMALL,
                criterion("share of the held-out deviance that it takes off", gain, ">", policy.least_gain),
            ),
            (Reason.NOT_SIGNIFICANT, criterion("adjusted p-value", p_value, "<", policy.alpha)),
        ]
    )
