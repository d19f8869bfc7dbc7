"""Which recording next: from what a search left in doubt to the recordings that would settle it, the best first.

An effect was found, and a rival could be in its place. If the effect is the true one, what would the rival leave on
the trials there are, together with those of a further recording? That is the information of `identifiability`, summed
over both: no search is run. The confidence set would reject a rival that leaves more than its bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.arrays import BoolArray, FloatArray
from schemas.sim_gap.recording_plan import OpenQuestion, PlannedRecording, RecordingPlan
from schemas.sim_gap.report import NamedEffect, Verdict
from simgap.inference.verdict_text import NAMED
from simgap.problem import Candidate, Model, Problem, Term, TrialSystem
from simgap.whole_trials.fit_model import ModelFit, fit_model
from simgap.whole_trials.identifiability import (
    Information,
    Probe,
    enough_to_reject,
    owned_by,
    probes_of,
    removal,
    total_information,
)
from simgap.whole_trials.ladder import ladder_of, starts_on, starts_up
from simgap.whole_trials.linearisation import linearise
from simgap.whole_trials.parameter_space import Space, vector_of
from simgap.whole_trials.policy import POLICY, Policy
from simgap.whole_trials.score_test import ProbedModel, scores
from simgap.whole_trials.search_models import extended_model

NOTHING = "Nothing is in doubt that another recording of this kind could settle."
NO_TRIALS = "Plans are worked out for mechanisms, whose whole trials are rolled out."


@dataclass(frozen=True)
class _InDoubt:
    """An effect of the model with the rivals that might be in its place."""

    term: Term
    rivals: tuple[Candidate, ...]


def plan_recordings(
    problem: Problem, trials: Sequence[str], verdict: Verdict, measurement: str, policy: Policy = POLICY
) -> RecordingPlan:
    """The plan for a verdict on these training trials; `measurement` is the recording's content hash."""
    problem = problem.with_input_timing()
    taught = problem.whole_trials(trials)
    questions = _questions(problem, verdict)
    if taught is None or not questions:
        words = NO_TRIALS if taught is None else NOTHING
        return RecordingPlan(measurement=measurement, statement=words)
    ladder = ladder_of(taught, problem.nuisances(), policy)
    null = ladder.nulls[-1]
    model = null.model
    for effect in verdict.effects:
        model = extended_model(model, _term(problem, effect))
    fit = fit_model(ladder.whole, model, starts_up(ladder.rungs, model, policy).starts, policy)
    now = _Trials.of(ladder.whole, fit, questions, policy)
    enough = enough_to_reject(fit, policy)
    doubts = _doubts(now, questions, fit, enough)
    planned: list[PlannedRecording] = []
    for recording in ladder.whole.plain.imagined(fit.model):
        system = recording.system.finer()
        starts = starts_on(recording.system, fit.model, policy).starts
        after = _Trials.at(system, fit, starts, now)
        left = tuple(
            information.left_by(0, k) for information in after.beside(now, recording.copies, fit, questions)
            for k in range(1, len(information.blocks))
        )  # fmt: skip
        planned.append(
            PlannedRecording(name=recording.name, words=recording.words, left=left, separates=min(left) >= enough)
        )
    planned.sort(key=lambda p: -min(p.left))
    return RecordingPlan(
        measurement=measurement, open_questions=doubts, recordings=tuple(planned), statement=_statement(doubts, planned)
    )


def _questions(problem: Problem, verdict: Verdict) -> list[_InDoubt]:
    """The effects that are not sure, each with the rivals that its group names."""
    out: list[_InDoubt] = []
    for effect in verdict.effects:
        if effect.confidence >= NAMED:
            continue
        names = {n for g in verdict.ambiguous_groups if effect.name in g.effects for n in g.effects} - {effect.name}
        rivals = [c for c in problem.candidates() if c.effect.name in names]
        beside = [c for c in rivals if c.where == effect.where]
        if chosen := tuple(beside or rivals):
            out.append(_InDoubt(_term(problem, effect), chosen))
    return out


def _term(problem: Problem, effect: NamedEffect) -> Term:
    """A reported effect as a term: the candidate whose bounds hold its values."""
    values = {n: e.value for n, e in effect.parameters.items()}
    same = [c for c in problem.candidates() if (c.effect.name, c.where) == (effect.name, effect.where)]

    def outside(candidate: Candidate) -> float:
        return sum(max(low - values[n], values[n] - high, 0.0) for n, (low, high) in candidate.bounds.items())

    candidate = min(same, key=lambda c: (outside(c), c.key))
    return Term(candidate, {n: float(np.clip(values[n], *candidate.bounds[n])) for n in candidate.null})


@dataclass(frozen=True)
class _Trials:
    """Trials with what each question's probes change there: totals of information, and the rivals' probed values."""

    totals: tuple[FloatArray, ...]
    probes: tuple[tuple[Probe, ...], ...]

    @staticmethod
    def of(system: TrialSystem, fit: ModelFit, questions: Sequence[_InDoubt], policy: Policy) -> _Trials:
        """The trials of a fit; each rival is probed where its score is best."""
        linear = linearise(system, fit.model, fit.starts)
        probed = ProbedModel.of(system, fit.model, fit.starts)
        totals, probes = [], []
        for question in questions:
            rivals = probes_of(probed, scores(system, fit, linear, question.rivals))
            asked = (removal(linear, fit.model, question.term), *rivals)
            totals.append(total_information(linear.only(_kept(fit.model, question.term)), asked))
            probes.append(asked)
        return _Trials(tuple(totals), tuple(probes))

    @staticmethod
    def at(system: TrialSystem, fit: ModelFit, starts: FloatArray, like: _Trials) -> _Trials:
        """Other trials, with the probes of the first."""
        linear, probed = linearise(system, fit.model, starts), ProbedModel.of(system, fit.model, starts)
        totals, probes = [], []
        for own, *rivals in like.probes:
            term = next(t for t in fit.model if t.candidate.key == own.candidate.key)
            asked = (removal(linear, fit.model, term), *(Probe.of(probed, r.candidate, r.values) for r in rivals))
            totals.append(total_information(linear.only(_kept(fit.model, term)), asked))
            probes.append(asked)
        return _Trials(tuple(totals), tuple(probes))

    def beside(self, first: _Trials, copies: int, fit: ModelFit, questions: Sequence[_InDoubt]) -> list[Information]:
        """By question, that of the first trials and of these, recorded so often."""
        space = Space.of(fit.model)
        prior = space.prior_precision * space.span**2
        return [
            Information.of_total(a + copies * b, prior[_kept(fit.model, q.term)], probes)
            for a, b, probes, q in zip(first.totals, self.totals, self.probes, questions, strict=True)
        ]


def _kept(model: Model, term: Term) -> BoolArray:
    """(p,) the parameters that are free beside a rival in a term's place."""
    return Space.of(model).inside(vector_of(model)) & ~owned_by(model, term)


def _doubts(now: _Trials, questions: Sequence[_InDoubt], fit: ModelFit, enough: float) -> tuple[OpenQuestion, ...]:
    alone = now.beside(now, 0, fit, questions)
    return tuple(
        OpenQuestion(
            effect=q.term.candidate.effect.name,
            where=q.term.candidate.where,
            rival=probe.candidate.effect.name,
            rival_where=probe.candidate.where,
            left=information.left_by(0, k),
            needed=enough,
        )
        for q, information, probes in zip(questions, alone, now.probes, strict=True)
        for k, probe in enumerate(probes[1:], 1)
    )


def _statement(doubts: Sequence[OpenQuestion], planned: Sequence[PlannedRecording]) -> str:
    if not planned:
        return "Each recording that could be imagined would leave the joints' limits."
    best, needed = planned[0], doubts[0].needed
    rivals = ", ".join(dict.fromkeys(d.rival for d in doubts))
    before, after = min(d.left for d in doubts), min(best.left)
    if best.separates:
        return (
            f"Best: {best.words}. A rival ({rivals}) in the place of {doubts[0].effect} would then leave a loss of "
            f"{after:.3g}, where {before:.3g} is left now and {needed:.3g} rejects it."
        )
    return (
        f"None of these recordings would settle it; nearest comes: {best.words} "
        f"({after:.3g} of the {needed:.3g} that rejects a rival; {before:.3g} now)."
    )
