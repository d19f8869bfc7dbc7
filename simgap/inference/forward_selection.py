"""Forward selection: which effects the trials need, one after another, and which cannot be distinguished.

Each round has three steps: screen all candidates, confirm the best, compare what is accepted with its competitors.
The null is the declared model with its nuisances refitted, never the default. Every training trial is judged once by
parameters that the others taught; gains are paired by trial, with Holm's correction over all candidates of a round.
The test trials have the last word: they must do better, in sum or typically.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Step
from simgap.inference.candidate_fit import Map, Screening, warm_start_without
from simgap.inference.comparison import (
    compare_with_alternatives,
    exchange_vanishing,
    with_possible_replacements,
    with_rivals_beside_confusable,
)
from simgap.inference.confirmation import confirm
from simgap.inference.decision import Decided, SearchDecision
from simgap.inference.fit import Fit, fit, robust_scale, rollout_errors
from simgap.inference.hypothesis import Accepted
from simgap.inference.losses import trial_losses
from simgap.inference.screening import screen
from simgap.inference.search_state import SearchState, refit_at
from simgap.problem import Problem
from simgap.recording.train_test_split import Trials

MOST_EFFECTS = 4
_TINY = 1e-12


@dataclass(frozen=True)
class Selection:
    """The null, the accepted effects in order, the last screening if it added none, and the final model.

    Losses are those of the test trials, in errors of `scale`; `decisions` are all decisions on candidates in order.
    """

    null: Fit
    null_losses: FloatArray
    accepted: tuple[Accepted, ...]
    undecided: Screening | None
    final: Fit
    final_losses: FloatArray
    scale: FloatArray
    decisions: tuple[SearchDecision, ...] = ()

    @property
    def screenings(self) -> tuple[Screening, ...]:
        """One per accepted effect, and the last if none was taken there."""
        return (*(a.screening for a in self.accepted), *([self.undecided] if self.undecided else []))


def select(problem: Problem, trials: Trials, each: Map | None = None, most: int = MOST_EFFECTS) -> Selection:
    """Null refit, then the best candidate of each screening while its gain is significant and above the least gain.

    At most `most` effects are accepted: 0 gives the null alone.
    """
    each = each or (lambda work, items: map(work, items))
    level = robust_scale(problem, (), trials.train)
    state = refit_at(problem, trials, fit(rollout_errors(problem, trials.train, level), problem.nuisances()))
    null = state.base
    accepted: tuple[Accepted, ...] = ()
    undecided: Screening | None = None
    exchanges = 0
    trail: list[SearchDecision] = []

    def record(number: int, step: Step, decisions: Sequence[Decided]) -> None:
        trail.extend(SearchDecision(number, step, candidate, decision) for candidate, decision in decisions)

    number = 0
    for number in count():
        compared = compare_with_alternatives(state, accepted, each)
        state, accepted = compared.state, compared.accepted
        record(number, "compare", compared.decisions)
        if len(accepted) == most:
            break
        taken = {c.key for c in state.base.free}
        screening = screen(state, [c for c in problem.candidates() if c.key not in taken], each)
        record(number, "screen", screening.decisions)
        if exchanges < most:
            exchange, decided = exchange_vanishing(state, screening, accepted, each)
            record(number, "compare", decided)
            if exchange is not None:
                place, effect = exchange
                accepted = (*accepted[:place], effect, *accepted[place + 1 :])
                state, exchanges = refit_at(problem, trials, effect.candidate_fit.fit), exchanges + 1
                continue
        accepted, decided = with_possible_replacements(state, screening, accepted)
        record(number, "compare", decided)
        confirmation = confirm(state, screening)
        record(number, "confirm", confirmation.decisions)
        record(number, "compare", confirmation.rivals)
        if confirmation.accepted is None:
            undecided = screening
            break
        accepted = (*accepted, confirmation.accepted)
        state = refit_at(problem, trials, confirmation.accepted.candidate_fit.fit)
    accepted, decided = with_rivals_beside_confusable(state, accepted)
    record(number, "compare", decided)
    accepted = tuple(replace(a, removed=_removed(state, a)) for a in accepted)
    scale = robust_scale(problem, null.model, trials.train)
    null_losses, losses = (
        trial_losses(problem.residuals(f.model, trials.test, "short_horizon"), scale) for f in (null, state.base)
    )
    return Selection(null, null_losses, accepted, undecided, state.base, losses, scale, tuple(trail))


def _removed(state: SearchState, accepted: Accepted) -> float:
    """Held-out loss that comes back in a refit without it, as a share of what is left with it."""
    without = fit(
        state.errors, warm_start_without(state.base, [accepted.candidate_fit.candidate], state.problem.nuisances())
    )
    return float(without.held_out.sum() / max(state.base.held_out.sum(), _TINY) - 1.0)
