"""Which models explain the trials: the null, then models of one, two, three effects, each grown from the best before.

From candidates and a ladder of trials to fitted models by size. Every size is screened by score tests on each rung;
the promising candidates are fitted up the ladder, from the values that the tests suggest. A size is entered only where
its best model is significantly and noticeably better than the best of the size before, on trials that taught it
nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Reason
from simgap.inference.candidate_fit import Map
from simgap.inference.decision import Decision, criterion, decide
from simgap.problem import Candidate, Model, Term, TrialSystem
from simgap.whole_trials.fit_model import ModelFit, fit_at, fit_model, loss_at
from simgap.whole_trials.held_out import held_out_losses, p_of_no_better
from simgap.whole_trials.ladder import Ladder, climb
from simgap.whole_trials.linearisation import linearise
from simgap.whole_trials.parameter_space import Space, vector_of
from simgap.whole_trials.policy import Policy
from simgap.whole_trials.score_test import Score, scores


@dataclass(frozen=True)
class FittedModel:
    """A model with its loss on trials that taught it nothing (t,)."""

    fit: ModelFit
    held_out: FloatArray

    @property
    def order(self) -> tuple[float, tuple[str, ...]]:
        """Best first; names decide ties."""
        return float(self.held_out.sum()), tuple(sorted(self.fit.keys))


@dataclass(frozen=True)
class Growth:
    """One step of the search: the best models of one size, in order, the scores behind them, whether it was entered.

    outranked   candidates of models that were not among the best on the way, in order.
    """

    models: tuple[FittedModel, ...]
    outranked: tuple[Candidate, ...]
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
    def sizes(self) -> tuple[FittedModel, ...]:
        """The best model of each size that was entered, from the null on."""
        return (self.null, *(g.models[0] for g in self.growths[: self.size]))

    def up_to(self, size: int, reason: Decision) -> ModelSearch:
        """The search as if the size after `size` had not been entered, for this reason."""
        refused = replace(self.growths[size], entered=reason)
        return ModelSearch(self.null, (*self.growths[:size], refused))

    @property
    def chosen(self) -> FittedModel:
        """The best model of the last size that was entered."""
        return self.growths[self.size - 1].models[0] if self.size else self.null


def search_models(
    ladder: Ladder, candidates: Sequence[Candidate], policy: Policy, most: int | None = None, each: Map | None = None
) -> ModelSearch:
    """Models of at most `most` effects (0: the null alone); `each` maps fits, over processes or not."""
    each = each or (lambda work, items: map(work, items))
    null = _fitted(ladder.nulls[-1])
    parents, growths = [Parent(null, ladder.nulls)], []
    for _ in range(policy.most_effects if most is None else most):
        growth = _grow(ladder, parents, candidates, policy, each)
        if growth is None:
            break
        growths.append(growth)
        if not growth.entered.kept:
            break
        parents = [Parent(m, _on_rungs(ladder, m.fit, policy)) for m in growth.models[: policy.beam]]
    return ModelSearch(null, tuple(growths))


@dataclass(frozen=True)
class Parent:
    """A model to extend, and what it leaves on every rung."""

    model: FittedModel
    rungs: tuple[ModelFit, ...]


def _fitted(fit: ModelFit) -> FittedModel:
    return FittedModel(fit, held_out_losses(fit))


def _on_rungs(ladder: Ladder, fit: ModelFit, policy: Policy) -> tuple[ModelFit, ...]:
    """A fitted model's starts on each shorter rung, its values unchanged."""
    shorter = [
        fit_model(system, fit.model, null.starts, policy, fixed=True, iterations=policy.rung_iterations)
        for system, null in zip(ladder.rungs[:-1], ladder.nulls[:-1], strict=True)
    ]
    return (*shorter, fit)


def _grow(
    ladder: Ladder, parents: Sequence[Parent], candidates: Sequence[Candidate], policy: Policy, each: Map
) -> Growth | None:
    fits: dict[frozenset[str], ModelFit] = {}
    first: tuple[Score, ...] = ()
    for parent in parents:
        rest = [c for c in candidates if c.key not in parent.model.fit.keys]
        by_rung = [
            scores(system, fit, linearise(system, fit.model, fit.starts), rest)
            for system, fit in zip(ladder.rungs, parent.rungs, strict=True)
        ]
        first = first or by_rung[-1]
        promising = _promising(by_rung, policy)
        for candidate, fit in zip(promising, each(_extending(ladder, parent, by_rung, policy), promising), strict=True):
            keys = parent.model.fit.keys | {candidate.key}
            if keys not in fits or fit.losses.sum() < fits[keys].losses.sum():
                fits[keys] = fit
    if not fits:
        return None
    by_loss = sorted(fits.values(), key=lambda f: float(f.losses.sum()))
    polished = [
        _without_idle(ladder.whole, _polished(ladder.whole, f, policy), policy) for f in by_loss[: policy.polished]
    ]
    ordered = tuple(sorted(map(_fitted, polished), key=lambda m: m.order))
    outranked = tuple(f.effects[-1].candidate for f in by_loss[policy.polished :])
    return Growth(
        ordered, outranked, first, _enters(ladder.nulls[-1], parents[0].model, ordered[0], len(candidates), policy)
    )


def _promising(by_rung: Sequence[Sequence[Score]], policy: Policy) -> list[Candidate]:
    """Candidates whose score comes near the best on some rung, in turn from each rung, best first."""
    chosen: dict[str, Candidate] = {}
    lists = []
    for ranked in by_rung:
        enough = max(policy.least_score, policy.promising * ranked[0].reduction) if ranked else 0.0
        lists.append([s.candidate for place, s in enumerate(ranked) if s.reduction >= enough or place < policy.fewest])
    for place in range(max((len(names) for names in lists), default=0)):
        for names in lists:
            if place < len(names) and len(chosen) < policy.full_fits:
                chosen.setdefault(names[place].key, names[place])
    return list(chosen.values())


def _extending(
    ladder: Ladder, parent: Parent, by_rung: Sequence[Sequence[Score]], policy: Policy
) -> Callable[[Candidate], ModelFit]:
    return lambda candidate: _extended(ladder, parent, candidate, by_rung, policy)


def _extended(
    ladder: Ladder, parent: Parent, candidate: Candidate, by_rung: Sequence[Sequence[Score]], policy: Policy
) -> ModelFit:
    """A model with a further effect, fitted up the ladder from what each rung suggests; the best of these fits."""
    own = [next(s for s in ranked if s.candidate.key == candidate.key) for ranked in by_rung]
    best = sorted(range(len(own)), key=lambda rung: -own[rung].reduction)[: policy.begins]
    fits = []
    for rung in [r for r in best if own[r].begins]:
        below = parent.rungs[rung]
        begun = [extended_model(below.model, Term(candidate, values)) for values in own[rung].begins]
        model = min(begun, key=lambda m: loss_at(ladder.rungs[rung], m, below.starts))
        fits.append(climb(ladder, rung, model, below.starts, policy))
    return min(fits, key=lambda f: float(f.losses.sum()))


def _polished(system: TrialSystem, fit: ModelFit, policy: Policy) -> ModelFit:
    """The fit continued to the end, and again with nuisances back at what is declared, where they reached a bound.

    They may have gone there before an effect that now does their work was there.
    """
    ended = fit_model(system, fit.model, fit.starts, policy)
    inside = Space.of(ended.model).inside(vector_of(ended.model))
    nuisance = np.array([t.candidate.nuisance for t in ended.model for _ in t.values], dtype=bool)
    if not (nuisance & ~inside).any():
        return ended
    model = tuple(Term(t.candidate, dict(t.candidate.null)) if t.candidate.nuisance else t for t in ended.model)
    again = fit_model(system, model, ended.starts, policy)
    return min((ended, again), key=_cost)


def _without_idle(system: TrialSystem, fit: ModelFit, policy: Policy) -> ModelFit:
    """The fit with those thresholds of its last effect back at none that no trial reaches: others may reach them."""
    *rest, term = fit.model
    if not term.candidate.extra_starts:
        return fit
    before = loss_at(system, fit.model, fit.starts)
    for name in term.candidate.strengths:
        idle = Term(term.candidate, term.values | {name: term.candidate.null[name]})
        if loss_at(system, (*rest, idle), fit.starts) <= before + policy.idle and idle.values != dict(
            term.candidate.null
        ):
            term = idle
    return fit_at(system, (*rest, term), fit.starts)


def _cost(fit: ModelFit) -> float:
    return float(fit.losses.sum()) + Space.of(fit.model).penalty(vector_of(fit.model))


def extended_model(model: Model, added: Term) -> Model:
    """The model with a further term, which takes the place of the nuisance of the same number."""
    new = added.candidate

    def same_number(term: Term) -> bool:
        old = term.candidate
        return old.nuisance and (old.effect.name, old.where, old.variant) == (new.effect.name, new.where, new.variant)

    return (*(t for t in model if not same_number(t)), added)


def _enters(null: ModelFit, before: FittedModel, after: FittedModel, candidates: int, policy: Policy) -> Decision:
    """Kept if the larger model is significantly and noticeably better on trials that taught it nothing."""
    degrees = len(after.fit.effects[-1].values)
    p_value = p_of_no_better(before.held_out, after.held_out, after.fit.dispersion, degrees)
    gain = float((before.held_out - after.held_out).sum() / after.fit.rows.sum())
    least = max(policy.least_gain, policy.least_share * float(null.losses.sum() / null.rows.sum()))
    return decide(
        [
            (Reason.TOO_SMALL, criterion("held-out loss per row that it takes off", gain, ">", least)),
            (
                Reason.NOT_SIGNIFICANT,
                criterion("adjusted p-value", min(1.0, candidates * p_value), "<", policy.alpha),
            ),
        ]
    )
