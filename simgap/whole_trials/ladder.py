"""A ladder of horizons: trials cut into short pieces whose starts are free, pieces twice as long, ..., whole trials.

Errors of short pieces depend nearly linearly on parameters and starts, so a fit finds its way there; whole trials can
say the most. Fits climb: values and starts found on one rung begin the next (multiple shooting; Bock, 1981).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from schemas.arrays import FloatArray
from simgap.problem import Candidate, Model, Term, TrialSystem
from simgap.whole_trials.fit_model import ModelFit, fit_model
from simgap.whole_trials.policy import Policy


@dataclass(frozen=True)
class Ladder:
    """The rungs from the shortest pieces to whole trials, these in finer steps, and the null model fitted on each."""

    rungs: tuple[TrialSystem, ...]
    nulls: tuple[ModelFit, ...]

    @property
    def whole(self) -> TrialSystem:
        """The last rung."""
        return self.rungs[-1]


def ladder_of(system: TrialSystem, nuisances: tuple[Candidate, ...], policy: Policy) -> Ladder:
    """The ladder over whole trials, with the noise that the null model's errors show from row to row."""
    null = tuple(Term(c, dict(c.start)) for c in nuisances)
    rungs = _rungs(system, policy)
    fits = _climbed(rungs, null, None, policy)
    system = system.with_noise_from(fits[-1].model, fits[-1].starts)
    rungs = _rungs(system, policy)
    *shorter, last = _climbed(rungs, null, None, policy)
    return Ladder(rungs, (*shorter, fit_model(rungs[-1], last.model, last.starts, policy)))


def _rungs(system: TrialSystem, policy: Policy) -> tuple[TrialSystem, ...]:
    shorter = (system.pieces(count) for count in policy.pieces)
    return (*(s for s in shorter if s is not None), system.finer())


def starts_on(system: TrialSystem, model: Model, policy: Policy) -> ModelFit:
    """A model of given values on whole trials, its starts fitted up a ladder."""
    return starts_up(_rungs(system, policy), model, policy)


def starts_up(rungs: tuple[TrialSystem, ...], model: Model, policy: Policy) -> ModelFit:
    """The same up these rungs."""
    first, *longer = rungs
    fit = fit_model(first, model, np.zeros_like(first.start_steps), policy, fixed=True)
    for below, rung in pairwise((first, *longer)):
        fit = fit_model(rung, model, _starts_from(below, fit, rung), policy, fixed=True)
    return fit


def _starts_from(below: TrialSystem, fit: ModelFit, rung: TrialSystem) -> FloatArray:
    """Starts of a rung as they were fitted on the one below, whose pieces begin there, too."""
    known = dict(zip(below.piece_starts, fit.starts, strict=True))
    return np.array([known[place] for place in rung.piece_starts])


def climb(ladder: Ladder, rung: int, model: Model, starts: FloatArray, policy: Policy) -> ModelFit:
    """A model fitted on a rung, from these values and starts, then on every longer one; its state on the last."""
    return _climbed(ladder.rungs[rung:], model, starts, policy)[-1]


def _climbed(
    rungs: tuple[TrialSystem, ...], model: Model, starts: FloatArray | None, policy: Policy
) -> tuple[ModelFit, ...]:
    fits: list[ModelFit] = []
    for number, system in enumerate(rungs):
        if fits:
            starts = _starts_from(rungs[number - 1], fits[-1], system)
        elif starts is None:
            # The starts alone first: as far off as they are, they would move the nuisances.
            starts = fit_model(system, model, np.zeros_like(system.start_steps), policy, fixed=True).starts
        fits.append(fit_model(system, model, starts, policy, iterations=policy.rung_iterations))
        model = fits[-1].model
    return tuple(fits)
