"""Comparison of two candidates by their direct estimates: held-out losses, and p-values beside each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from schemas.sim_gap.decisions import Reason
from simgap.inference.candidate_fit import ALPHA, CandidateFit
from simgap.inference.competing_hypotheses import AHEAD_GAIN
from simgap.inference.decision import Decision, Test, criterion, decide, place_name
from simgap.inference.losses import compare
from simgap.problem import DirectEstimate, Problem, Term

DIRECT_ALPHA = 0.05


def is_better(best: DirectEstimate, other: DirectEstimate) -> Decision | None:
    """Kept if `best` leaves less than `other`, beyond chance and smoothing; None where one has no held-out losses."""
    if best.held_out is None or other.held_out is None:
        return None
    ahead = compare(other.held_out, best.held_out)
    return decide(
        [
            (Reason.NOT_SIGNIFICANT, criterion("p of the direct losses", ahead.p_value, "<", ALPHA)),
            (Reason.TOO_SMALL, criterion("gain of the direct losses", ahead.gain, ">", AHEAD_GAIN)),
        ]
    )


def distinguishes(
    problem: Problem, best: CandidateFit, rival: CandidateFit, others: tuple[Term, ...], trials: Sequence[str]
) -> Decision:
    """Kept if the direct route keeps the best beside the rival, drops the rival beside the best, and prefers the best.

    Else the best is mimicked by the rival; a p-value without an estimate is NaN.

    The comparison uses fits that start afresh: a rival's term that got stuck where the simulator left it would
    be no match for anything.
    """
    best_term, rival_term = best.fit.model[-1], rival.fit.model[-1]

    def tests() -> Iterator[Test]:
        given_rival = problem.direct(best.candidate, (*others, rival_term), trials)
        yield Reason.MIMICKED_BY, criterion("direct p beside the other", _p_value(given_rival), "<", ALPHA)
        given_best = problem.direct(rival.candidate, (*others, best_term), trials)
        yield Reason.MIMICKED_BY, criterion("direct p of the other beside it", _p_value(given_best), ">", DIRECT_ALPHA)
        alone, other = (problem.direct(t.candidate, others, trials) for t in (best, rival))
        better = None if alone is None or other is None else is_better(alone, other)
        yield from () if better is None else ((Reason.MIMICKED_BY, c) for c in better.criteria)

    return decide(tests(), beside=place_name(rival.candidate))


def _p_value(estimate: DirectEstimate | None) -> float:
    return math.nan if estimate is None else estimate.p_value
