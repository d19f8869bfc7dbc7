"""The answer of a search, and the parts of its report that do not depend on how effects were searched."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import CandidateDecision
from schemas.sim_gap.extension import AppliedEffect, Estimate, ModelExtension
from schemas.sim_gap.report import Baseline, Gain, GapReport, NamedEffect
from simgap.inference.decision import SearchDecision
from simgap.inference.losses import Comparison, compare
from simgap.inference.verdict_text import NAMED
from simgap.problem import Candidate, DirectEstimate, Model, Problem
from simgap.recording.train_test_split import Trials

_NORMAL_95 = 1.96


@dataclass(frozen=True)
class SearchResult:
    """The report and the extension, and for pictures the final model and its effects, best first."""

    report: GapReport
    extension: ModelExtension
    final_model: Model
    accepted: tuple[Candidate, ...]


def extension_of(measurement: str, effects: Sequence[NamedEffect]) -> ModelExtension:
    """The effects that are sure, as an extension of the model; `measurement` is the recording's content hash."""
    named = [e for e in effects if e.confidence >= NAMED]
    return ModelExtension(
        measurement=measurement,
        effects=tuple(AppliedEffect(name=e.name, where=e.where, parameters=e.parameters) for e in named),
    )


def reported(decision: SearchDecision) -> CandidateDecision:
    """A decision of a search as the report lists it."""
    return CandidateDecision(
        round_number=decision.round_number,
        step=decision.step,
        name=decision.candidate.effect.name,
        where=decision.candidate.where,
        kept=decision.decision.kept,
        reason=decision.decision.reason,
        beside=decision.decision.beside,
        criteria=decision.decision.criteria,
    )


def reported_estimates(candidate: Candidate, direct: DirectEstimate | None) -> dict[str, Estimate]:
    """A direct estimate by parameter, with 95 % intervals; nothing where there is none."""
    if direct is None:
        return {}
    units = {q.name: q.unit for q in candidate.effect.parameters}
    reach = {n: _NORMAL_95 * error for n, error in direct.standard_errors.items()}
    return {n: Estimate(value=v, unit=units[n], ci95=(v - reach[n], v + reach[n])) for n, v in direct.values.items()}


def baseline_of(problem: Problem, trials: Trials) -> Baseline:
    """Root mean square error of the declared model per channel over all trials, with intervals over trials."""
    residuals = problem.residuals((), (*trials.train, *trials.test), "short_horizon")
    squares = np.array([np.nanmean(r**2, axis=0) for r in residuals])
    draws = np.random.default_rng(0).integers(0, len(squares), (1000, len(squares)))
    spread = np.quantile(np.sqrt(squares[draws].mean(axis=1)), [0.025, 0.975], axis=0)
    metrics = {
        f"{name}_rmse": Estimate(
            value=float(np.sqrt(squares[:, c].mean())), unit="SI", ci95=(float(spread[0, c]), float(spread[1, c]))
        )
        for c, name in enumerate(problem.channels())
    }
    return Baseline(metrics=metrics)


def gain_of(
    problem: Problem,
    null: Model,
    final: Model,
    trials: Trials,
    view: Literal["short_horizon", "full_rollout"],
    horizon_s: float,
) -> Gain:
    """Held-out root mean square error, in noise levels, of the null refit and of the extended model."""
    floor = problem.noise_floor(trials.test, view)
    before, after = (
        np.array([float(np.nanmean((r / floor) ** 2)) for r in problem.residuals(model, trials.test, view)])
        for model in (null, final)
    )
    return gain_between(before, after, view, horizon_s)


def gain_between(
    before: FloatArray, after: FloatArray, view: Literal["short_horizon", "full_rollout"], horizon_s: float
) -> Gain:
    """From mean squared errors per trial (n,), in noise levels, of two models."""
    comparison: Comparison = compare(before, after)
    was, now = float(np.sqrt(before.mean())), float(np.sqrt(after.mean()))
    root = [1.0 - np.sqrt(max(1.0 - g, 0.0)) for g in (comparison.gain, *comparison.ci95)]
    return Gain(
        view=view,
        horizon_s=horizon_s,
        metric="rms error in noise levels",
        heldout_before=was,
        heldout_after=now,
        reduction=float(root[0]),
        ci95=(float(root[1]), float(root[2])),
        noise_floor=1.0,
        gap_closed=float(np.clip((was - now) / (was - 1.0), 0.0, 1.0)) if was > 1.0 else 1.0,
    )


def rms_in_noise_levels(problem: Problem, model: Model, trials: Sequence[str]) -> float:
    """Of short roll-outs of these trials."""
    floor = problem.noise_floor(trials, "short_horizon")
    squares = [np.nanmean((e / floor) ** 2) for e in problem.residuals(model, trials, "short_horizon")]
    return float(np.sqrt(np.mean(squares)))
