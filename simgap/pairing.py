"""Whether the inputs of a recording belong to its motions: files paired wrongly look like physics.

A model that is driven by the inputs of its own trial must come nearer to the motion than one that is driven by those
of another trial. Where it does not, whatever the search finds is no name.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from schemas.gap import Trap
from simgap.problem import Model, Problem, View
from simgap.score import paired_p, trial_losses

LEVEL = 0.05


@runtime_checkable
class Driven(Protocol):
    """A problem whose motions answer to recorded inputs."""

    def misdriven(self) -> Problem | None:
        """The same motions with inputs of the next trial; None where nothing drives or all trials are driven alike."""
        ...


def pairing_trap(problem: Problem, model: Model, trials: Sequence[str], view: View) -> Trap | None:
    """Whether `model` does better with each trial's own inputs; None where that cannot be asked."""
    other = problem.misdriven() if isinstance(problem, Driven) else None
    if other is None or len(trials) < 3:
        return None
    scale = np.maximum(problem.noise_floor(trials, view), 1e-12)
    own, swapped = (trial_losses(p.residuals(model, trials, view), scale) for p in (problem, other))
    p = paired_p(swapped, own)
    evidence = f"inputs of another trial make the error {np.exp(np.mean(np.log(swapped / own))):.2f} times as large"
    return Trap(
        name="inputs_belong", status="ok" if p < LEVEL else "suspect", evidence=f"{evidence} (p = {p:.2g} for chance)"
    )
