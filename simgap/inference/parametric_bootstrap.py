"""Bias of the method by parametric bootstrap: what fit and direct estimate give on data simulated without an effect.

A parametric bootstrap (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 6): the accepted model gives
readings with the same stamps, inputs and noise, in finer steps; whatever both routes then find of the effect comes
from smoothing, steps and noise. Only effects that are about to be accepted are tested.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import stats

from simgap.inference.fit import extend, fit, is_twin, robust_scale, rollout_errors
from simgap.problem import Model, Problem

_REPEATS = 3
_DESCENT_STEPS = 4  # of a descent that begins where the truth is


@dataclass(frozen=True)
class MethodBias:
    """Per parameter: half the width of what 95 % of repeats without the effect show, by roll-outs and directly."""

    fitted: Mapping[str, float] = field(default_factory=dict)
    direct: Mapping[str, float] = field(default_factory=dict)


def estimate_method_bias(problem: Problem, trials: Sequence[str], base: Model, model: Model) -> MethodBias:
    """Bias on the last term of `model`, from samples simulated by `base`; empty for a problem without bootstrap."""
    term = model[-1]
    # There the numbers of `base` are the declared ones.
    known = [
        replace(t.candidate, start=t.values, null=t.values if t.candidate.nuisance else t.candidate.null) for t in base
    ]
    given = tuple(replace(t, candidate=c) for t, c in zip(base, known, strict=True))
    none = {n: term.candidate.null[n] for n in term.candidate.strengths}
    none |= next((t.values for t in base if is_twin(t.candidate, term.candidate)), {})
    fitted: list[dict[str, float]] = []
    direct: list[dict[str, float]] = []
    for seed in range(_REPEATS):
        again = problem.bootstrap_sample(base, seed)
        if again is None:
            return MethodBias()
        errors = rollout_errors(again, trials, robust_scale(again, given, trials))
        null = fit(errors, known, _DESCENT_STEPS)
        direct_estimate = again.direct(term.candidate, null.model, trials)
        # Nothing is hidden here: a descent from the found values alone may be stuck where the loss is higher.
        starts = [
            {**term.values, **none},
            term.values,
            *([direct_estimate.values] if direct_estimate is not None else []),
        ]
        extended = extend(errors, null, term.candidate, starts, _DESCENT_STEPS)
        fitted.append(extended.model[-1].values)
        if direct_estimate is not None:
            direct.append(direct_estimate.values)
    return MethodBias(prediction_half_widths(none, fitted), prediction_half_widths(none, direct))


def prediction_half_widths(none: Mapping[str, float], estimates: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The furthest from `none` that another repeat would come, 95 %, by the narrower of two of Student's ranges.

    One takes the repeats to scatter about `none`; the other about their own mean, where a bias that all share counts
    once and not as if it could be of either sign and any size.
    """
    if not estimates:
        return {}
    n = len(estimates)
    about_none, about_mean = float(stats.t.ppf(0.975, n)), float(stats.t.ppf(0.975, n - 1)) * np.sqrt(1.0 + 1.0 / n)
    out = {}
    for name, at in none.items():
        off = np.array([v[name] for v in estimates]) - at
        biased = abs(float(off.mean())) + about_mean * float(off.std(ddof=1)) if n > 1 else np.inf
        out[name] = min(about_none * float(np.sqrt((off**2).mean())), float(biased))
    return out
