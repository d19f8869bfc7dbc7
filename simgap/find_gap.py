"""From a problem and its split into trials to a report: baseline error, selected effects, verdict, held-out gains.

Start here to read the sim gap: `find_effects` calls every step of the pipeline once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from schemas.sim_gap.decisions import CandidateDecision, Reason
from schemas.sim_gap.report import ConventionCheck, GapReport, Hypothesis, Localisation, Rival
from simgap.baselines.all_effects import all_effects_losses
from simgap.baselines.black_box import black_box_losses
from simgap.inference.agreement import agrees
from simgap.inference.candidate_fit import Map
from simgap.inference.decision import Decided, SearchDecision
from simgap.inference.forward_selection import Selection, select
from simgap.inference.losses import compare
from simgap.inference.verdict import judge
from simgap.problem import Model, Problem
from simgap.recording.train_test_split import Trials
from simgap.search_result import (
    SearchResult,
    baseline_of,
    extension_of,
    gain_of,
    reported,
    reported_estimates,
    rms_in_noise_levels,
)
from simgap.whole_trials.find import find_on_whole_trials


def find_effects(
    problem: Problem,
    trials: Trials,
    *,
    measurement: str,
    horizon_s: float,
    checks: tuple[ConventionCheck, ...] = (),
    localisation: tuple[Localisation, ...] = (),
    each: Map | None = None,
    quick: bool = False,
) -> SearchResult:
    """The answer of a problem. `measurement` is the content hash of its recording.

    Deterministic; the caller sets the wall time, which is 0 here.

    `quick` leaves out the baseline with all effects at once.
    """
    if problem.whole_trials(trials.train) is not None:
        return find_on_whole_trials(
            problem,
            trials,
            measurement=measurement,
            horizon_s=horizon_s,
            checks=checks,
            localisation=localisation,
            each=each,
            quick=quick,
        )
    selection = select(problem, trials, each)
    box = black_box_losses(problem, selection.final.model, trials, selection.scale)
    leftover = compare(selection.final_losses, box)
    null, final = selection.null.model, selection.final.model
    short = gain_of(problem, null, final, trials, "short_horizon", horizon_s)
    gains = (short, gain_of(problem, null, final, trials, "full_rollout", 0.0))
    judgement = judge(problem, selection, trials.train, gains, leftover)
    verdict = judgement.verdict
    decisions = reported_decisions(selection.decisions, judgement.decisions)
    report = GapReport(
        measurement=measurement,
        n_train=len(trials.train),
        n_test=len(trials.test),
        wall_s=0.0,
        traps=checks,
        baseline=baseline_of(problem, trials),
        localisation=localisation,
        hypotheses=_hypotheses(selection),
        verdict=verdict,
        gains=gains,
        gain=short,
        baselines=(
            Rival(name="null_refit", heldout=float(selection.null_losses.mean())),
            *(() if quick else (_all_effects(problem, selection, trials),)),
            Rival(name="black_box", heldout=float(box.mean())),
        ),
        ladder=_ablation(problem, selection, trials),
        decisions=decisions,
        reason_counts=dict(sorted(Counter(d.reason for d in decisions).items())),
    )
    accepted = tuple(a.candidate_fit.candidate for a in selection.accepted)
    return SearchResult(report, extension_of(measurement, verdict.effects), final, accepted)


def _all_effects(problem: Problem, selection: Selection, trials: Trials) -> Rival:
    losses = all_effects_losses(problem, selection.null.model, trials, selection.scale)
    return Rival(name="all_effects", heldout=float(losses.mean()))


def _ablation(problem: Problem, selection: Selection, trials: Trials) -> tuple[Rival, ...]:
    """Held-out rms error in noise levels: declared, null refit, each accepted effect added, noise."""

    def step(name: str, model: Model) -> Rival:
        return Rival(name=name, heldout=rms_in_noise_levels(problem, model, trials.test))

    final = selection.final.model
    accepted = [a.key for a in selection.accepted]
    steps = [step("declared", ()), step("null_refit", selection.null.model)]
    for k in range(1, len(accepted) + 1):
        remaining = tuple(t for t in final if t.candidate.key not in accepted[k:])
        last_added = selection.accepted[k - 1].candidate_fit.candidate
        steps.append(step(f"{last_added.effect.name} at {last_added.where}", remaining))
    return (*steps, Rival(name="noise_floor", heldout=1.0))


def reported_decisions(searched: Sequence[SearchDecision], judged: Sequence[Decided]) -> tuple[CandidateDecision, ...]:
    """The decisions of the search and those on accepted effects after it, as the report lists them.

    What passed the screening is listed by what the later steps of that round decided.
    """
    last = max((d.round_number for d in searched), default=0)
    every = (*searched, *(SearchDecision(last, "judge", candidate, decision) for candidate, decision in judged))
    return tuple(reported(d) for d in every if d.step != "screen" or not d.decision.kept)


def _hypotheses(selection: Selection) -> tuple[Hypothesis, ...]:
    """All candidates of the first round, and those of later rounds that were accepted there; best first."""
    rows = []
    for number, screening in enumerate(selection.screenings):
        accepted = {a.key for a in selection.accepted[number : number + 1]}
        for candidate_fit, p in zip(screening.fits, screening.p_adjusted, strict=True):
            if number > 0 and candidate_fit.candidate.key not in accepted:
                continue
            agreement = agrees(candidate_fit)
            rows.append(
                Hypothesis(
                    name=candidate_fit.candidate.effect.name,
                    where=candidate_fit.candidate.where,
                    heldout_gain=candidate_fit.comparison.gain,
                    ci95=candidate_fit.comparison.ci95,
                    p_adjusted=p,
                    delta_bic=candidate_fit.delta_bic,
                    direct=reported_estimates(candidate_fit.candidate, candidate_fit.direct),
                    direct_agrees=None if agreement.reason is Reason.NO_DIRECT_ESTIMATE else agreement.kept,
                )
            )
    return tuple(rows)
