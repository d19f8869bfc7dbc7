"""Checks by permutation whether the inputs of a recording belong to its motions: paired tests of roll-out losses.

Driven by the inputs of its own trial a model must come nearer to the motion than driven by those of another trial.
Where those of another do better from the start, there is nothing to search; where they do as well in the end, whatever
the search found is no name.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.report import ConventionCheck
from simgap.inference.losses import paired_p, trial_losses
from simgap.problem import Model, Problem

ALPHA = 0.05
# The first look comes before anything is known of the model: only what no model could turn round stops a search.
FIRST_ALPHA = 1e-3
OFFSETS = (1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6)  # files are shifted by few places, if by a rule


def other_inputs_check(problem: Problem) -> ConventionCheck | None:
    """Whether inputs of other trials fit the motions better than their own; None where that cannot be tested.

    The model is the declared one. Which other trial fits is found on one half of the recording and judged on the
    other, so that a choice among many is no advantage (Student's test over trials).
    """
    trials = problem.trial_ids
    places = [by for by in OFFSETS if 2 * abs(by) < len(trials) or 2 * by == len(trials)]
    others = [problem.with_permuted_inputs(by) for by in places]
    if len(trials) < 3 or not any(others):
        return None
    scale = np.maximum(problem.noise_floor(trials, "short_horizon"), 1e-12)
    own = _halves(problem, trials, scale)
    losses_of_others = np.array([_halves(other, trials, scale) for other in others if other is not None])
    row = np.arange(len(trials))
    best = losses_of_others[:, :, 0].argmin(axis=0), losses_of_others[:, :, 1].argmin(axis=0)
    theirs = losses_of_others[best[0], row, 1] + losses_of_others[best[1], row, 0]
    p_value = paired_p(own.sum(axis=1), theirs)
    ratio = float(np.exp(np.mean(np.log(own.sum(axis=1) / theirs))))
    return ConventionCheck(
        name="inputs_of_others",
        status="suspect" if p_value < FIRST_ALPHA else "ok",
        evidence=f"with its own inputs a motion's error is {ratio:.3g} times as large as with the best of "
        f"{len(losses_of_others)} others (p = {p_value:.2g} for chance)",
    )


def _halves(problem: Problem, trials: Sequence[str], scale: FloatArray) -> FloatArray:
    """(n, 2) mean squared error of the declared model over the first and second half of each trial's roll-outs."""
    parts = [np.array_split(r / scale, 2) for r in problem.residuals((), trials, "short_horizon")]
    return np.array([[float(np.nanmean(np.square(half))) for half in halves] for halves in parts])


def pairing_check(problem: Problem, model: Model, trials: Sequence[str]) -> ConventionCheck | None:
    """Whether `model` does better with each trial's own inputs; None where that cannot be tested."""
    other = problem.with_permuted_inputs()
    if other is None or len(trials) < 3:
        return None
    scale = np.maximum(problem.noise_floor(trials, "short_horizon"), 1e-12)
    own, swapped = (trial_losses(p.residuals(model, trials, "short_horizon"), scale) for p in (problem, other))
    p = paired_p(swapped, own)
    evidence = f"inputs of another trial make the error {np.exp(np.mean(np.log(swapped / own))):.2f} times as large"
    return ConventionCheck(
        name="inputs_belong", status="ok" if p < ALPHA else "suspect", evidence=f"{evidence} (p = {p:.2g} for chance)"
    )
