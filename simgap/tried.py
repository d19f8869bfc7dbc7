"""One candidate tried on top of a model: its fit, and how it does on training trials held out in turn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from simgap.fit import Fit
from simgap.problem import Candidate, DirectEstimate
from simgap.score import Comparison, compare, met_p

LEVEL = 0.05  # chance of one false name per round; the direct route and the test trials must agree besides
LEAST_GAIN = 0.04  # a share of the loss (half of it of the error), or of the noise, below which no effect has a name


@dataclass(frozen=True)
class Trial:
    """One candidate tried on top of a base model: its fit, and how it does on training trials held out in turn."""

    candidate: Candidate
    fit: Fit
    comparison: Comparison
    direct: DirectEstimate | None
    delta_bic: float


@dataclass(frozen=True)
class Round:
    """All candidates tried on one base, best first; `p_adjusted` beside them."""

    tried: tuple[Trial, ...]
    p_adjusted: tuple[float, ...]


def tried_on(base: Fit, extended: Fit, direct: DirectEstimate | None) -> Trial:
    """The last term of `extended` as a candidate on top of `base`; both fitted to errors of the same trials."""
    comparison = compare(base.held_out, extended.held_out)
    if extended.free[-1].probes:
        comparison = replace(comparison, p_value=met_p(base.held_out, extended.held_out))
    comparison = replace(comparison, p_value=chance(comparison, extended))
    return Trial(extended.free[-1], extended, comparison, direct, _delta_bic(base, extended))


def chance(comparison: Comparison, extended: Fit) -> float:
    """Chance of such evidence without the effect, by held-out losses or by the strength itself: two looks, so twice.

    The strength of a threshold says nothing: there it is one look.
    """
    if extended.free[-1].probes:
        return comparison.p_value
    return min(1.0, 2.0 * min(comparison.p_value, extended.p_value))


def _delta_bic(base: Fit, fitted: Fit) -> float:
    """BIC of the base minus BIC with the effect; trials are the samples."""
    n = len(base.losses)
    extra = len(fitted.free[-1].null)
    return float(n * np.log(max(base.losses.mean(), 1e-12) / max(fitted.losses.mean(), 1e-12)) - extra * np.log(n))


def warm(found: Fit) -> list[Candidate]:
    """Terms as candidates that start at their present values."""
    return [replace(t.candidate, start=t.values) for t in found.model]
