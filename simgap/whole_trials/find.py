"""The answer of a problem with whole trials: search, check on test trials, verdict, report.

Read in this order: `ladder` (horizons), `search_models`, `confidence_set`, `check`, `judge`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from schemas.sim_gap.decisions import CandidateDecision, Reason, Step
from schemas.sim_gap.report import ConventionCheck, GapReport, Hypothesis, Localisation, Rival
from simgap.baselines.all_effects import all_effects_losses
from simgap.baselines.black_box import black_box_losses
from simgap.inference.candidate_fit import Map
from simgap.inference.decision import Decision, SearchDecision, criterion, decide, negation, place_name
from simgap.inference.fit import robust_scale
from simgap.inference.losses import compare, trial_losses
from simgap.problem import Candidate, Model, Problem
from simgap.recording.train_test_split import Trials
from simgap.sanity.input_pairing import other_inputs_check, pairing_check
from simgap.search_result import (
    SearchResult,
    baseline_of,
    extension_of,
    gain_between,
    gain_of,
    reported,
    reported_estimates,
    rms_in_noise_levels,
)
from simgap.whole_trials.check import check_whole_trials, confirmed
from simgap.whole_trials.confidence_set import ConfidenceSet, confidence_set
from simgap.whole_trials.identifiability import identifiable, twins
from simgap.whole_trials.judge import JudgedModel, judge
from simgap.whole_trials.ladder import Ladder, ladder_of, starts_up
from simgap.whole_trials.linearisation import linearise
from simgap.whole_trials.policy import POLICY, Policy
from simgap.whole_trials.score_test import Score, scores
from simgap.whole_trials.search_models import FittedModel, Growth, ModelSearch, search_models


def find_on_whole_trials(
    problem: Problem,
    trials: Trials,
    *,
    measurement: str,
    horizon_s: float,
    checks: tuple[ConventionCheck, ...] = (),
    localisation: tuple[Localisation, ...] = (),
    each: Map | None = None,
    quick: bool = False,
    policy: Policy = POLICY,
) -> SearchResult:
    """See `simgap.find_gap.find_effects`; for problems that have whole trials."""
    others = other_inputs_check(problem)
    mixed_up = others is not None and others.status == "suspect"
    problem = problem.with_input_timing()
    taught, judged = problem.whole_trials(trials.train), problem.whole_trials(trials.test)
    assert taught is not None
    assert judged is not None
    ladder = ladder_of(taught, problem.nuisances(), policy)
    search = search_models(ladder, problem.candidates(), policy, 0 if mixed_up else None, each)
    search = confirmed(judged, search, policy)
    models = confidence_set(search, policy)
    null, final = search.null.fit.model, search.chosen.fit.model
    shown = tuple(starts_up(ladder.rungs, model, policy) for model in (null, final))
    check = check_whole_trials(judged, null, final, (shown[0], shown[1]), policy)
    pairing = pairing_check(problem, final, trials.train)
    pairing_checks = [c for c in (others, pairing) if c is not None]
    timing = problem.timing_check()
    short = gain_of(problem, null, final, trials, "short_horizon", horizon_s)
    gains = (short, gain_between(check.null, check.final, "full_rollout", 0.0))
    strange = any(c.status == "suspect" for c in pairing_checks)
    same = _twins(ladder, search, models, problem.candidates(), policy)
    judgement = judge(problem, models, check, gains, trials.train, strange, same, policy)
    decisions = _decisions(search, models, judgement, policy)
    report = GapReport(
        measurement=measurement,
        n_train=len(trials.train),
        n_test=len(trials.test),
        wall_s=0.0,
        traps=(*checks, *pairing_checks, *([timing] if timing else [])),
        baseline=baseline_of(problem, trials),
        localisation=localisation,
        identifiable=identifiable(ladder.whole, ladder.nulls[-1], search.growths[0].scores, policy)
        if search.growths
        else (),
        hypotheses=_hypotheses(search, judgement),
        verdict=judgement.verdict,
        gains=gains,
        gain=short,
        baselines=_baselines(problem, null, final, trials, quick),
        ladder=_ablation(problem, search, trials),
        decisions=decisions,
        reason_counts=dict(sorted(Counter(d.reason for d in decisions).items())),
    )
    accepted = tuple(t.candidate for t in search.chosen.fit.effects)
    return SearchResult(report, extension_of(measurement, judgement.verdict.effects), final, accepted)


def _twins(
    ladder: Ladder, search: ModelSearch, models: ConfidenceSet, candidates: Sequence[Candidate], policy: Policy
) -> dict[str, tuple[Candidate, ...]]:
    """See `twins`, of the chosen model; without candidates that were fitted in an effect's place and rejected."""
    fit = search.chosen.fit
    if not fit.effects:
        return {}
    if search.size < len(search.growths):
        beside = search.growths[search.size].scores
    else:
        rest = [c for c in candidates if c.key not in fit.keys]
        beside = scores(ladder.whole, fit, linearise(ladder.whole, fit.model, fit.starts), rest)
    rejected = {
        (effect, other)
        for model, decision in models.decisions
        if decision.kept
        for effect in fit.keys - model.fit.keys
        for other in model.fit.keys - fit.keys
    }
    imitators = twins(ladder.whole, fit, beside, policy)
    return {effect: tuple(c for c in same if (effect, c.key) not in rejected) for effect, same in imitators.items()}


def _baselines(problem: Problem, null: Model, final: Model, trials: Trials, quick: bool) -> tuple[Rival, ...]:
    """Mean losses of the test trials on short roll-outs, in errors of the null: what names nothing beside the null."""
    scale = robust_scale(problem, null, trials.train)
    losses = {"null_refit": trial_losses(problem.residuals(null, trials.test, "short_horizon"), scale)}
    if not quick:
        losses["all_effects"] = all_effects_losses(problem, null, trials, scale)
    losses["black_box"] = black_box_losses(problem, final, trials, scale)
    return tuple(Rival(name=name, heldout=float(values.mean())) for name, values in losses.items())


def _ablation(problem: Problem, search: ModelSearch, trials: Trials) -> tuple[Rival, ...]:
    """Held-out rms error in noise levels: declared, null refit, each effect of the chosen model added, noise."""
    final, effects = search.chosen.fit.model, search.chosen.fit.effects
    steps: list[tuple[str, Model]] = [("declared", ()), ("null_refit", search.null.fit.model)]
    for k, term in enumerate(effects, 1):
        without = {t.candidate.key for t in effects[k:]}
        model = tuple(t for t in final if t.candidate.key not in without)
        steps.append((f"{term.candidate.effect.name} at {term.candidate.where}", model))
    rows = [Rival(name=name, heldout=rms_in_noise_levels(problem, model, trials.test)) for name, model in steps]
    return (*rows, Rival(name="noise_floor", heldout=1.0))


def _decisions(
    search: ModelSearch, models: ConfidenceSet, judgement: JudgedModel, policy: Policy
) -> tuple[CandidateDecision, ...]:
    """Of each step on candidates: not fitted, the models of each size, those that stay in doubt, the verdict."""
    out: list[CandidateDecision] = []

    def record(number: int, step: Step, candidate: Candidate, decision: Decision) -> None:
        out.append(reported(SearchDecision(number, step, candidate, decision)))

    for number, growth in enumerate(search.growths):
        fitted = {c.key for c in growth.outranked} | {key for model in growth.models for key in model.fit.keys}
        for score in growth.scores:
            if score.candidate.key not in fitted:
                record(number, "screen", score.candidate, _not_fitted(score, growth, policy))
        record(number, "confirm", growth.models[0].fit.effects[-1].candidate, growth.entered)
        for rank, model in enumerate(growth.models[1:], 2) if number != search.size - 1 else ():
            best = criterion("rank by held-out loss", rank, "<=", 1)
            record(number, "confirm", model.fit.effects[-1].candidate, decide([(Reason.OUTRANKED, best)]))
        for rank, candidate in enumerate(growth.outranked, len(growth.models) + 1):
            among_best = criterion("rank by loss", rank, "<=", policy.polished)
            record(number, "confirm", candidate, decide([(Reason.OUTRANKED, among_best)]))
    for model, rejected in models.decisions:
        for term in model.fit.effects:
            if term.candidate.key not in models.models[0].fit.keys:
                stays = _stays(model, rejected, models.models[0])
                record(max(search.size - 1, 0), "compare", term.candidate, stays)
    for candidate, decision in judgement.decisions:
        record(max(search.size - 1, 0), "judge", candidate, decision)
    return tuple(out)


def _not_fitted(score: Score, growth: Growth, policy: Policy) -> Decision:
    """Why a candidate was not fitted: its score is noise, far below the best, or others came first."""
    fitted = len(growth.models) + len(growth.outranked)
    share = score.reduction / max(growth.scores[0].reduction, 1e-300)
    return decide(
        [
            (
                Reason.NOT_PROMISING,
                criterion("loss that a linear step takes off whole trials", score.reduction, ">=", policy.least_score),
            ),
            (Reason.NOT_PROMISING, criterion("share of the best score", share, ">=", policy.promising)),
            (
                Reason.OUTRANKED,
                criterion("models that were fitted", fitted, "<", policy.full_fits),
            ),
        ]
    )


def _stays(model: FittedModel, rejected: Decision, chosen: FittedModel) -> Decision:
    """Whether a model stays in doubt with the chosen one, from whether it is rejected."""
    beside = place_name(next(t.candidate for t in chosen.fit.effects if t.candidate.key not in model.fit.keys))
    if rejected.kept:
        return decide([(Reason.FITS_WORSE_THAN, negation(rejected.criteria[0]))], beside=beside)
    return Decision(True, Reason.INSEPARABLE_FROM, (negation(rejected.criteria[-1]),), beside)


def _hypotheses(search: ModelSearch, judgement: JudgedModel) -> tuple[Hypothesis, ...]:
    """The effect that each fitted model adds to the best of the size before, best first, size by size."""
    rows: list[Hypothesis] = []
    before = search.null
    for growth in search.growths:
        for model in growth.models:
            added: Sequence[Candidate] = [
                t.candidate for t in model.fit.effects if t.candidate.key not in before.fit.keys
            ]
            if len(added) != 1:
                continue
            candidate = added[0]
            comparison = compare(before.fit.deviance / before.fit.rows, model.fit.deviance / model.fit.rows)
            penalty = len(candidate.null) * float(np.log(model.fit.rows.sum()))
            estimate, agreement = judgement.direct.get(candidate.key, (None, None))
            rows.append(
                Hypothesis(
                    name=candidate.effect.name,
                    where=candidate.where,
                    heldout_gain=comparison.gain,
                    ci95=comparison.ci95,
                    p_adjusted=growth.entered.criteria[-1].value
                    if model is growth.models[0] and len(growth.entered.criteria) > 1
                    else 1.0,
                    delta_bic=float(before.fit.losses.sum() - model.fit.losses.sum()) - penalty,
                    direct=reported_estimates(candidate, estimate),
                    direct_agrees=None if estimate is None or agreement is None else agreement.kept,
                )
            )
        if not growth.entered.kept:
            break
        before = growth.models[0]
    return tuple(rows)
