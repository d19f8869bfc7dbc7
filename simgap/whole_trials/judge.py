"""The verdict from a search on whole trials: an effect is sure where every reason for doubt is absent.

An effect is sure if whole test trials come down to the noise, every model of the confidence set has it, its interval
excludes none, the inputs belong to the motions, and the direct route, which simulates nothing, agrees on it: on the
strength, and on the shape of the force.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from schemas.sim_gap.decisions import Reason
from schemas.sim_gap.report import AmbiguousGroup, Gain, NamedEffect, Verdict
from simgap.inference.agreement import NO_DIRECT_ESTIMATE, agree, with_fixed_shape
from simgap.inference.decision import Decided, Decision, all_of, criterion, decide, place_name
from simgap.inference.intervals import Sides, differs_from_none, parameters, symmetric, threshold_excess, wider
from simgap.inference.repeating_shape import Structure, shape_of, structures
from simgap.inference.verdict_text import NAMED, STRANGE, statement, status
from simgap.problem import Candidate, DirectEstimate, Leftover, Model, Problem, Term
from simgap.whole_trials.check import WholeTrialCheck
from simgap.whole_trials.confidence_set import ConfidenceSet
from simgap.whole_trials.fit_model import half_widths
from simgap.whole_trials.policy import Policy

_NORMAL_95 = 1.96


@dataclass(frozen=True)
class JudgedModel:
    """A verdict with the decisions behind it: per effect that it is named, or each reason for doubt."""

    verdict: Verdict
    decisions: tuple[Decided, ...]
    direct: dict[str, tuple[DirectEstimate | None, Decision]]


def judge(
    problem: Problem,
    models: ConfidenceSet,
    check: WholeTrialCheck,
    gains: Sequence[Gain],
    trials: Sequence[str],
    strange: bool,
    twins: Mapping[str, Sequence[Candidate]],
    policy: Policy,
) -> JudgedModel:
    """The verdict on the chosen model. Where the data are `strange`, nothing is sure: inputs may be another trial's.

    `twins` are candidates by the key of the effect whose place they could take (`identifiability`).
    """
    chosen = models.models[0].fit
    widths = half_widths(chosen, _NORMAL_95)
    named: list[NamedEffect] = []
    groups: list[AmbiguousGroup] = []
    decisions: list[Decided] = []
    direct: dict[str, tuple[DirectEstimate | None, Decision]] = {}
    leftovers = problem.leftovers(chosen.model, problem.trial_ids)
    every_structure = structures(leftovers, policy.alpha)
    misshapen: list[Candidate] = []
    for term in chosen.effects:
        own, others = widths[term.candidate.key], tuple(t for t in chosen.model if t is not term)
        like_it = (*twins.get(term.candidate.key, ()), *_same_law(problem, term.candidate))
        others_like_it = (*models.alternatives(term), *like_it)
        alternatives = list({a.key: a for a in others_like_it if not _same_name(a, term.candidate)}.values())
        estimate, agreement = _direct_agreement(problem, term, own, others, trials)
        direct[term.candidate.key] = estimate, agreement
        sides: Sides = wider(symmetric(own), symmetric(threshold_excess(term)))
        every = [
            decide([(Reason.INPUTS_OF_OTHERS, criterion("failed checks of input pairing", int(strange), "<=", 0))]),
            check.explains,
            differs_from_none(term, sides),
            *(_inseparable(a) for a in alternatives),
            agreement,
            shape := shape_of(term.candidate.key, leftovers, every_structure, policy.alpha, policy.shape_share),
        ]
        doubts = [d for d in every if not d.kept]
        named.append(
            NamedEffect(
                name=term.candidate.effect.name,
                where=term.candidate.where,
                confidence=_confidence(doubts, estimate, policy),
                routes={"heldout": True, "direct": agreement.kept},
                parameters=parameters(term, sides),
            )
        )
        if not doubts:
            decisions.append((term.candidate, replace(all_of(every), reason=Reason.NAMED)))
            if shape.reason is Reason.SHAPE_HIDDEN:
                decisions.append((term.candidate, shape))
            continue
        decisions += [(term.candidate, doubt) for doubt in doubts]
        if doubts == [shape]:
            misshapen.append(term.candidate)
        elif check.explains.kept:
            names = tuple(dict.fromkeys([term.candidate.effect.name, *(a.effect.name for a in alternatives)]))
            groups.append(AmbiguousGroup(effects=names, experiment=experiment_for(term.candidate, alternatives)))
    certain = any(e.confidence >= NAMED for e in named)
    unexplained = not check.explains.kept
    if strange:
        words = STRANGE
    else:
        words = _outside(gains[-1], named) if unexplained else statement(gains, named, groups, bool(misshapen))
        if misshapen and not (unexplained or certain or groups):
            words = _another_force(problem, misshapen, every_structure[0], leftovers[every_structure[0].number])
    verdict = Verdict(
        status="outside_model_class" if unexplained or strange else status(certain, bool(groups), bool(misshapen)),
        effects=tuple(named),
        ambiguous_groups=tuple(groups),
        statement=words,
    )
    return JudgedModel(verdict, tuple(decisions), direct)


def _outside(whole: Gain, named: Sequence[NamedEffect]) -> str:
    """The sentence where no model explains whole trials: how much is left, and what comes nearest."""
    left = f"{whole.heldout_after:.3g} noise levels (rms) are left of {whole.heldout_before:.3g}"
    near = " and ".join(f"{e.name} at {e.where}" for e in named)
    nearest = f"; what comes nearest is {near}, not sure" if named else ""
    return f"Something outside the library acts: no model of it brings whole trials down to the noise, {left}{nearest}."


def _another_force(problem: Problem, misshapen: Sequence[Candidate], seen: Structure, leftover: Leftover) -> str:
    """The sentence where whole trials come down to the noise, but the balance shows a force of another shape."""
    names = " and ".join(place_name(c) for c in misshapen)
    size = seen.size * float(leftover.noise[seen.channel])
    unit, channel = problem.channel_units()[seen.channel], problem.channels()[seen.channel]
    return (
        f"Something outside the library acts, it seems: with {names} whole trials come down to the noise, but in the "
        f"balance of forces {size:.2g} {unit}/s2 (rms) of {channel} repeats along {seen.words}, which no values of the "
        f"model explain."
    )


def experiment_for(candidate: Candidate, alternatives: Sequence[Candidate]) -> str:
    """The library's experiments that distinguish an effect from its alternatives, or from its usual confusables."""
    names = {a.effect.name for a in alternatives}
    named = [c.experiment for c in candidate.effect.confusables if c.effect in names]
    theirs = [c.experiment for a in alternatives for c in a.effect.confusables if c.effect == candidate.effect.name]
    usual = [c.experiment for c in candidate.effect.confusables[:1]]
    return "; ".join(dict.fromkeys(named + theirs or usual)) or "more trials with larger and smaller motion"


def _same_law(problem: Problem, candidate: Candidate) -> list[Candidate]:
    """Candidates that are one law with an effect here: input that comes late, and a reading that does.

    A joint answers a late input late; inside the loop of a drive it does not, because the loop sees it late.
    """
    if len(problem.channels()) != 1 or candidate.variant:
        return []
    names = {c.effect for c in candidate.effect.confusables if c.same_for_one_joint}
    return [c for c in problem.candidates() if c.effect.name in names and not c.variant]


def _same_name(a: Candidate, b: Candidate) -> bool:
    return (a.effect.name, a.where) == (b.effect.name, b.where)


def _inseparable(other: Candidate) -> Decision:
    test = criterion("models of the confidence set without the effect", 1, "<=", 0)
    return Decision(False, Reason.INSEPARABLE_FROM, (test,), place_name(other))


def _direct_agreement(
    problem: Problem, term: Term, widths: dict[str, float], others: Model, trials: Sequence[str]
) -> tuple[DirectEstimate | None, Decision]:
    """The direct estimate beside the other effects, and whether it agrees; strengths are compared at one shape."""
    estimate = problem.direct(term.candidate, others, trials)
    if estimate is None:
        return None, NO_DIRECT_ESTIMATE
    agreement = agree(term, widths, estimate)
    if agreement.kept or not term.candidate.shapes:
        return estimate, agreement
    pinned = problem.direct(with_fixed_shape(term), others, trials)
    return estimate, agreement if pinned is None else agree(term, widths, pinned)


def _confidence(doubts: Sequence[Decision], direct: DirectEstimate | None, policy: Policy) -> float:
    """At least `NAMED` without a doubt, more the clearer the direct route is; one half and less with doubts."""
    if doubts or direct is None:
        return 0.5 / max(len(doubts), 1)
    return NAMED + (1.0 - NAMED) * (1.0 - policy.alpha) * (1.0 - min(1.0, direct.p_value))
