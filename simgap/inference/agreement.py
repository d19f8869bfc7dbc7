"""Whether the direct estimate says the same as the fit: the second of the two routes to a name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from simgap.inference.candidate_fit import CandidateFit
from simgap.inference.direct_comparison import DIRECT_ALPHA
from simgap.inference.parametric_bootstrap import MethodBias
from simgap.problem import Candidate, DirectEstimate, Model, Problem, Term

AGREE_ERRORS = 3.0
AGREE_SHARE = 0.5  # of the larger of the two: within a factor of two, either way
_LOOKS = 2.0  # at losses and at strengths, as on roll-outs
_HELD = 1e-6  # a range so narrow holds a value, relative


def agrees(candidate_fit: CandidateFit) -> bool | None:
    """Whether the direct estimate says the same as the fit; None where there is no direct route."""
    if candidate_fit.direct is None:
        return None
    return agree(candidate_fit.fit.model[-1], candidate_fit.fit.half_widths[candidate_fit.candidate.key], candidate_fit.direct)


def agree(term: Term, widths: dict[str, float], direct: DirectEstimate) -> bool:
    """Whether both point one way and lie within a factor of two of one another, or within their errors."""
    strength = _strength(term, widths)
    null, fitted = term.candidate.null[strength], term.values[strength]
    step = fitted - null
    apart = direct.values[strength] - fitted
    noise = float(np.hypot(direct.standard_errors[strength], widths.get(strength, 0.0) / 1.96))
    slack = max(AGREE_ERRORS * noise, AGREE_SHARE * max(abs(step), abs(direct.values[strength] - null)))
    one_way = step * (direct.values[strength] - null) > 0.0
    return _is_significant(direct, term.candidate, strength) and one_way and abs(apart) <= slack


def direct_agreement(
    problem: Problem,
    candidate_fit: CandidateFit,
    term: Term,
    widths: dict[str, float],
    others: Model,
    trials: Sequence[str],
    alone: bool,
) -> tuple[DirectEstimate | None, bool]:
    """What the direct route says of an accepted effect beside the others, and whether that agrees with the fit.

    What is said is said of the final model: values move when causes are found that were not yet known. And a strength
    means something beside a shape only: torque at rest beside the speed at which it is gone.
    """
    direct = candidate_fit.direct
    if direct is None or (alone and agree(term, widths, direct)):
        return direct, direct is not None
    direct = problem.direct(candidate_fit.candidate, others, trials)
    if direct is None or agree(term, widths, direct) or not term.candidate.shapes:
        return direct, direct is not None and agree(term, widths, direct)
    pinned = problem.direct(of_one_shape(term), others, trials)
    if pinned is None or not agree(term, widths, pinned):
        return direct, False
    return _shapes_of(direct, pinned, term.candidate), True


def beyond(term: Term, direct: DirectEstimate, method_bias: MethodBias) -> bool:
    """Whether the direct route sees more of some strength than it makes up where there is none."""
    null = term.candidate.null
    return not method_bias.direct or any(
        abs(direct.values[n] - null[n]) > least for n, least in method_bias.direct.items()
    )


def _is_significant(direct: DirectEstimate, candidate: Candidate, strength: str) -> bool:
    """Whether a direct estimate differs from none beyond chance: by trials held out, or by its error over trials.

    The second sees far smaller effects, as on roll-outs; it says nothing of a threshold, which is sharp anywhere.
    """
    error = direct.standard_errors[strength]
    if direct.p_value < DIRECT_ALPHA or candidate.extra_starts or direct.trials < 2 or error <= 0.0:
        return direct.p_value < DIRECT_ALPHA
    t = abs(direct.values[strength] - candidate.null[strength]) / error
    return bool(_LOOKS * 2.0 * stats.t.sf(t, direct.trials - 1) < DIRECT_ALPHA)


def _shapes_of(free: DirectEstimate, pinned: DirectEstimate, candidate: Candidate) -> DirectEstimate:
    """What is said of strengths at one shape, and of shapes where nothing is held."""
    return replace(
        pinned,
        values={n: (free if n in candidate.shapes else pinned).values[n] for n in pinned.values},
        standard_errors={n: (free if n in candidate.shapes else pinned).standard_errors[n] for n in pinned.values},
    )


def of_one_shape(term: Term) -> Candidate:
    """The candidate with its shape held as it was fitted: strengths of two routes then compare."""
    held = {n: (v - _HELD * (abs(v) + _HELD), v + _HELD * (abs(v) + _HELD)) for n, v in term.values.items()}
    bounds = {n: held[n] if n in term.candidate.shapes else b for n, b in term.candidate.bounds.items()}
    return replace(term.candidate, start=term.values, bounds=bounds)


def _strength(term: Term, widths: dict[str, float]) -> str:
    """The parameter that says most clearly that the effect is there: a stop may be touched on one side only."""

    def clarity(n: str) -> float:
        width = widths.get(n, 0.0)
        return abs(term.values[n] - term.candidate.null[n]) / width if width > 0.0 else 0.0

    return max(term.candidate.strengths, key=clarity)
