"""Comparison of two candidates by their direct estimates: held-out losses, and p-values beside each other."""

from __future__ import annotations

from collections.abc import Sequence

from simgap.inference.candidate_fit import ALPHA, CandidateFit
from simgap.inference.competing_hypotheses import AHEAD_GAIN
from simgap.inference.losses import compare
from simgap.problem import DirectEstimate, Problem, Term

DIRECT_ALPHA = 0.05


def is_better(best: DirectEstimate, other: DirectEstimate) -> bool | None:
    """Whether `best` leaves less than `other`, beyond chance and smoothing; None where one has no held-out losses."""
    if best.held_out is None or other.held_out is None:
        return None
    ahead = compare(other.held_out, best.held_out)
    return ahead.p_value < ALPHA and ahead.gain > AHEAD_GAIN


def distinguishes(
    problem: Problem, best: CandidateFit, rival: CandidateFit, others: tuple[Term, ...], trials: Sequence[str]
) -> bool:
    """Whether the direct route keeps the best beside the rival, drops the rival beside the best, and prefers the best.

    The comparison uses fits that start afresh: a rival's term that got stuck where the simulator left it would
    be no match for anything.
    """
    best_term, rival_term = best.fit.model[-1], rival.fit.model[-1]
    given_rival = problem.direct(best.candidate, (*others, rival_term), trials)
    given_best = problem.direct(rival.candidate, (*others, best_term), trials)
    kept = given_rival is not None and given_rival.p_value < ALPHA
    dropped = given_best is not None and given_best.p_value > DIRECT_ALPHA
    if not (kept and dropped):
        return False
    alone, other = (problem.direct(t.candidate, others, trials) for t in (best, rival))
    return alone is None or other is None or is_better(alone, other) is not False
