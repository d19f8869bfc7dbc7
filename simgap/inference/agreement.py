"""Agreement of the direct estimate with the fit on roll-outs: the second of the two conditions for a name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from schemas.sim_gap.decisions import Criterion, Reason
from simgap.inference.candidate_fit import CandidateFit
from simgap.inference.decision import Decision, criterion, decide, either
from simgap.inference.direct_comparison import DIRECT_ALPHA
from simgap.inference.parametric_bootstrap import MethodBias
from simgap.problem import Candidate, DirectEstimate, Model, Problem, Term

AGREE_ERRORS = 3.0
AGREE_SHARE = 0.5  # of the larger of the two: within a factor of two, either way
_TESTS = 2.0  # of losses and of strengths, as on roll-outs: a Bonferroni factor
_FIXED_RANGE = 1e-6  # relative half width of the bounds that fix a value
NO_DIRECT_ESTIMATE = decide([(Reason.NO_DIRECT_ESTIMATE, criterion("direct estimates", 0, ">", 0))])


def agrees(candidate_fit: CandidateFit) -> Decision:
    """Kept if the direct estimate agrees with the fit; without a direct estimate that is the reason."""
    if candidate_fit.direct is None:
        return NO_DIRECT_ESTIMATE
    return agree(
        candidate_fit.fit.model[-1], candidate_fit.fit.half_widths[candidate_fit.candidate.key], candidate_fit.direct
    )


def agree(term: Term, widths: dict[str, float], direct: DirectEstimate) -> Decision:
    """Kept if both have one sign and lie within a factor of two of one another, or within their errors."""
    strength = _strength(term, widths)
    null, fitted = term.candidate.null[strength], term.values[strength]
    step = fitted - null
    apart = direct.values[strength] - fitted
    noise = float(np.hypot(direct.standard_errors[strength], widths.get(strength, 0.0) / 1.96))
    slack = max(AGREE_ERRORS * noise, AGREE_SHARE * max(abs(step), abs(direct.values[strength] - null)))
    one_way = step * (direct.values[strength] - null)
    return decide(
        [
            (Reason.DIRECT_NOT_SIGNIFICANT, _significance(direct, term.candidate, strength)),
            (Reason.DIRECT_DISAGREES, criterion(f"product of both estimates of {strength}", one_way, ">", 0.0)),
            (Reason.DIRECT_DISAGREES, criterion(f"distance of both estimates of {strength}", abs(apart), "<=", slack)),
        ]
    )


def direct_agreement(
    problem: Problem,
    candidate_fit: CandidateFit,
    term: Term,
    widths: dict[str, float],
    others: Model,
    trials: Sequence[str],
    alone: bool,
) -> tuple[DirectEstimate | None, Decision]:
    """The direct estimate of an accepted effect beside the other effects, and the decision whether it agrees.

    Both belong to the final model: values move as further effects are accepted. Strengths are compared at one shape,
    because a strength depends on it: torque at rest beside the speed at which it has decayed.
    """
    direct = candidate_fit.direct
    if direct is None:
        return None, NO_DIRECT_ESTIMATE
    if alone and (agreement := agree(term, widths, direct)).kept:
        return direct, agreement
    direct = problem.direct(candidate_fit.candidate, others, trials)
    if direct is None:
        return None, NO_DIRECT_ESTIMATE
    agreement = agree(term, widths, direct)
    if agreement.kept or not term.candidate.shapes:
        return direct, agreement
    pinned = problem.direct(with_fixed_shape(term), others, trials)
    if pinned is None:
        return direct, agreement
    agreement = agree(term, widths, pinned)
    return (_strengths_at_fixed_shape(direct, pinned, term.candidate) if agreement.kept else direct), agreement


def exceeds_method_bias(term: Term, direct: DirectEstimate, method_bias: MethodBias) -> Decision:
    """Kept if the direct estimate of some strength exceeds the bias of the direct method."""
    null = term.candidate.null
    distances = [
        criterion(f"distance of the direct {n} from no effect", abs(direct.values[n] - null[n]), ">", least)
        for n, least in method_bias.direct.items()
    ]
    return decide([(Reason.METHOD_BIAS, either(*distances))] if distances else [])


def _significance(direct: DirectEstimate, candidate: Candidate, strength: str) -> Criterion:
    """Whether a direct estimate differs from none beyond chance: by held-out losses, or by its error over trials.

    The second test detects far smaller effects, as on roll-outs. Thresholds have the first test only: their standard
    error is small wherever they lie.
    """
    error = direct.standard_errors[strength]
    of_losses = criterion("direct p-value", direct.p_value, "<", DIRECT_ALPHA)
    if of_losses.holds or candidate.extra_starts or direct.trials < 2 or error <= 0.0:
        return of_losses
    t = abs(direct.values[strength] - candidate.null[strength]) / error
    p_value = _TESTS * 2.0 * float(stats.t.sf(t, direct.trials - 1))
    return criterion(f"direct p-value of {strength} over its error", p_value, "<", DIRECT_ALPHA)


def _strengths_at_fixed_shape(free: DirectEstimate, pinned: DirectEstimate, candidate: Candidate) -> DirectEstimate:
    """Strengths from the estimate at a fixed shape, shapes from the free one."""
    return replace(
        pinned,
        values={n: (free if n in candidate.shapes else pinned).values[n] for n in pinned.values},
        standard_errors={n: (free if n in candidate.shapes else pinned).standard_errors[n] for n in pinned.values},
    )


def with_fixed_shape(term: Term) -> Candidate:
    """The candidate with its shape fixed as fitted, so that strengths of fit and direct estimate compare."""

    def margin(value: float) -> float:
        return _FIXED_RANGE * (abs(value) + _FIXED_RANGE)

    held = {n: (v - margin(v), v + margin(v)) for n, v in term.values.items()}
    bounds = {n: held[n] if n in term.candidate.shapes else b for n, b in term.candidate.bounds.items()}
    return replace(term.candidate, start=term.values, bounds=bounds)


def _strength(term: Term, widths: dict[str, float]) -> str:
    """The strength with the largest ratio to its half width: a stop may be touched on one side only."""

    def clarity(n: str) -> float:
        width = widths.get(n, 0.0)
        return abs(term.values[n] - term.candidate.null[n]) / width if width > 0.0 else 0.0

    return max(term.candidate.strengths, key=clarity)
