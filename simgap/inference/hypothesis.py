"""A candidate's evidence as data, and the tests that decide whether it becomes an accepted effect.

Evidence is gathered in the order of its cost: the fit on the training trials, losses of the test trials, a parametric
bootstrap. Each test is a function of the evidence alone and returns a decision with its reason.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.decisions import Reason
from simgap.inference.candidate_fit import ALPHA, CandidateFit, Screening, least_gain
from simgap.inference.competing_hypotheses import adds_to
from simgap.inference.decision import Decision, Test, all_of, criterion, decide, either
from simgap.inference.fit import Fit
from simgap.inference.parametric_bootstrap import MethodBias

_TINY = 1e-12


@dataclass(frozen=True)
class Evidence:
    """What the trials show of one candidate on top of a base model.

    p_adjusted   its p-value, adjusted over all candidates of its screening.
    test_losses  (n,) losses of the test trials before and with it; None until they are computed.
    method_bias  estimate of it on data simulated without it; None until it is computed.
    """

    base: Fit
    candidate_fit: CandidateFit
    p_adjusted: float
    test_losses: tuple[FloatArray, FloatArray] | None = None
    method_bias: MethodBias | None = None


@dataclass(frozen=True)
class Accepted:
    """An effect that was taken.

    p_adjusted   its p-value, adjusted over all candidates of its `screening`.
    rivals       candidates that the trials do not separate from it.
    method_bias  estimate of it on data simulated without it.
    removed      loss that comes back without it, as a share of what is left in the end.
    """

    candidate_fit: CandidateFit
    screening: Screening
    p_adjusted: float
    rivals: tuple[CandidateFit, ...]
    method_bias: MethodBias
    removed: float = np.inf

    @property
    def key(self) -> str:
        """Of its candidate."""
        return self.candidate_fit.candidate.key


def is_significant(evidence: Evidence) -> Decision:
    """Kept if the gain is no chance and large enough, and the values differ from none and add to the base."""
    candidate_fit, base = evidence.candidate_fit, evidence.base

    def tests() -> Iterator[Test]:
        yield Reason.NOT_SIGNIFICANT, criterion("adjusted p-value", evidence.p_adjusted, "<", ALPHA)
        # Of what is left, or of the noise.
        removed = candidate_fit.comparison.gain * min(1.0, float(base.held_out.mean()))
        least = least_gain(candidate_fit.candidate)
        yield Reason.TOO_SMALL, criterion("share of the loss removed", removed, ">", least)

    def decisions() -> Iterator[Decision]:
        yield decide(tests())
        yield candidate_fit.fit.strength_exceeds({})
        yield adds_to(base, candidate_fit.fit)

    return all_of(decisions())


def is_confirmed(evidence: Evidence) -> Decision:
    """Kept if the test trials do better with it, in sum or typically: one cause of two may leave one trial worse."""
    assert evidence.test_losses is not None
    before, after = evidence.test_losses
    most = 1.0 - 0.5 * least_gain(evidence.candidate_fit.candidate)
    typical = np.exp(np.mean(np.log((after + _TINY) / (before + _TINY))))
    ratios = (
        criterion("ratio of test losses, sum", after.sum() / before.sum(), "<", most),
        criterion("ratio of test losses, typical", typical, "<", most),
    )
    return decide([(Reason.TEST_TRIALS_WORSE, either(*ratios))])


def is_beyond_method_bias(evidence: Evidence) -> Decision:
    """Kept if some strength exceeds what the method finds on data simulated without the effect."""
    assert evidence.method_bias is not None
    return evidence.candidate_fit.fit.strength_exceeds(evidence.method_bias.fitted)
