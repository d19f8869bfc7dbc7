"""Fits of single candidates on top of a base model, with cross-validated gains and p-values, ranked by gain."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simgap.inference.decision import Decided
from simgap.inference.fit import Fit, is_twin
from simgap.inference.losses import Comparison, compare, holm_adjusted
from simgap.problem import Candidate, DirectEstimate

ALPHA = 0.05  # chance of one false name per round; the direct route and the test trials must agree besides
_LEAST_GAIN = 0.04  # minimum gain of a named effect, share of the loss (half of it of the error) or of the noise
# Minimum gain of effects that a direct estimate confirms: beside other causes they may hardly lower the loss.
_CONFIRMED_LEAST_GAIN = 0.01


def least_gain(candidate: Candidate) -> float:
    """Minimum gain of a candidate with a name, as a share of the loss or of the noise."""
    return _CONFIRMED_LEAST_GAIN if candidate.direct_half_width else _LEAST_GAIN


@dataclass(frozen=True)
class CandidateFit:
    """One candidate fitted on top of a base model, compared with the base by cross-validation over training trials."""

    candidate: Candidate
    fit: Fit
    comparison: Comparison
    direct: DirectEstimate | None
    delta_bic: float


Map = Callable[[Callable[[Candidate], Any], Iterable[Candidate]], Iterable[Any]]  # in order, over processes or not


@dataclass(frozen=True)
class Screening:
    """Fits of all candidates on one base, best first, with their adjusted p-values.

    decisions   which candidates were fitted to the end.
    """

    fits: tuple[CandidateFit, ...]
    p_adjusted: tuple[float, ...]
    decisions: tuple[Decided, ...] = ()

    def p_of(self, key: str) -> float:
        """Adjusted p-value of a candidate; 1 for one that was not fitted."""
        return next((p for t, p in zip(self.fits, self.p_adjusted, strict=True) if t.candidate.key == key), 1.0)


def ranked_screening(tried: Sequence[CandidateFit]) -> Screening:
    """Fits of all candidates on one base, best first, with Holm's correction for their number."""
    ordered = sorted(tried, key=lambda t: (-t.comparison.gain, t.candidate.key))
    p_adjusted = holm_adjusted([t.comparison.p_value for t in ordered])
    return Screening(tuple(ordered), tuple(float(p) for p in p_adjusted))


def direct_held_out_loss(candidate_fit: CandidateFit) -> float:
    """Cross-validated loss of the direct estimate, summed over trials; infinite where there is none."""
    direct = candidate_fit.direct
    return np.inf if direct is None or direct.held_out is None else float(direct.held_out.sum())


def candidate_fit_on(base: Fit, extended: Fit, direct: DirectEstimate | None) -> CandidateFit:
    """The last term of `extended` as a candidate on top of `base`; both fitted to errors of the same trials."""
    comparison = compare(base.held_out, extended.held_out)
    comparison = replace(comparison, p_value=combined_p_value(comparison, extended))
    return CandidateFit(extended.free[-1], extended, comparison, direct, _delta_bic(base, extended))


def combined_p_value(comparison: Comparison, extended: Fit) -> float:
    """p-value of "no effect" from held-out losses and from the strength: the smaller of the two, times two."""
    return min(1.0, 2.0 * min(comparison.p_value, extended.p_value))


def _delta_bic(base: Fit, fitted: Fit) -> float:
    """BIC of the base minus BIC with the effect; trials are the samples."""
    n = len(base.losses)
    extra = len(fitted.free[-1].null)
    return float(n * np.log(max(base.losses.mean(), 1e-12) / max(fitted.losses.mean(), 1e-12)) - extra * np.log(n))


def warm_start(fitted: Fit) -> list[Candidate]:
    """Terms as candidates that start at their present values."""
    return [replace(t.candidate, start=t.values) for t in fitted.model]


def warm_start_without(fitted: Fit, removed: Sequence[Candidate], nuisances: Sequence[Candidate]) -> list[Candidate]:
    """`warm_start` without some effects; a declared number that one of them had replaced is a nuisance again."""
    keys = {c.key for c in removed}
    remaining = [c for c in warm_start(fitted) if c.key not in keys]
    present = {c.key for c in remaining}
    return [*(n for n in nuisances if n.key not in present and any(is_twin(n, c) for c in removed)), *remaining]
