"""The model confidence set: fitted models of the chosen size that the trials do not reject.

A model leaves the set if the chosen one is significantly better than it on trials that taught neither (Hansen, Lunde,
Nason, Econometrica 79, 2011, with the chosen model as the benchmark). An effect is certain where it is in every model
of the set; effects that take one another's places form a group.
"""

from __future__ import annotations

from dataclasses import dataclass

from schemas.sim_gap.decisions import Reason
from simgap.inference.decision import Decision, criterion, decide
from simgap.problem import Candidate, Term
from simgap.whole_trials.held_out import p_of_no_better
from simgap.whole_trials.policy import Policy
from simgap.whole_trials.search_models import FittedModel, ModelSearch


@dataclass(frozen=True)
class ConfidenceSet:
    """The chosen model first, then the others that are not rejected, with the decision on each model of its size."""

    models: tuple[FittedModel, ...]
    decisions: tuple[tuple[FittedModel, Decision], ...]

    @property
    def certain(self) -> frozenset[str]:
        """Keys of effects in every model of the set."""
        return frozenset.intersection(*(m.fit.keys for m in self.models))

    def alternatives(self, term: Term) -> tuple[Candidate, ...]:
        """Candidates that take the place of a term of the chosen model in another model of the set, best first."""
        own = self.models[0].fit.keys
        out: dict[str, Candidate] = {}
        for model in self.models[1:]:
            if term.candidate.key not in model.fit.keys:
                out |= {t.candidate.key: t.candidate for t in model.fit.effects if t.candidate.key not in own}
        return tuple(out.values())


def confidence_set(search: ModelSearch, policy: Policy) -> ConfidenceSet:
    """From all models of the chosen size; the null alone where no effect was taken."""
    chosen = search.chosen
    if not search.size:
        return ConfidenceSet((chosen,), ())
    rivals = [m for m in search.growths[search.size - 1].models if m is not chosen]
    decisions = tuple((m, _rejected(m, chosen, policy)) for m in rivals)
    return ConfidenceSet((chosen, *(m for m, d in decisions if not d.kept)), decisions)


def _rejected(model: FittedModel, chosen: FittedModel, policy: Policy) -> Decision:
    """Kept, as a rejection, where the chosen model is significantly and noticeably better."""
    p_value = p_of_no_better(model.held_out, chosen.held_out, chosen.fit.dispersion, 1)
    lead = float((model.held_out - chosen.held_out).sum() / chosen.fit.rows.sum())
    return decide(
        [
            (
                Reason.INSEPARABLE_FROM,
                criterion("p-value of no better held-out loss", p_value, "<", policy.rejection_alpha),
            ),
            (Reason.INSEPARABLE_FROM, criterion("held-out loss per row ahead", lead, ">", policy.least_lead)),
        ]
    )
