"""Baseline without selection: all candidates fitted at once by CMA-ES within a budget; losses of the test trials.

N. Hansen, The CMA evolution strategy: a tutorial, arXiv 1604.00772. This is what identification tools do with the
parameters that a user lists; it names nothing, and with as many parameters it may follow noise.
"""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from simgap.inference.losses import trial_losses
from simgap.problem import Candidate, Model, Problem, Term
from simgap.recording.train_test_split import Trials

_PER_PARAMETER, _MOST_ROLLOUTS = 6, 150  # roll-outs of the training trials: about a third of what the search takes
_CMA_STEP = 0.05  # of each parameter's range
_SEED = 1


def all_effects_losses(problem: Problem, base: Model, trials: Trials, scale: FloatArray) -> FloatArray:
    """(n,) losses of the test trials under all candidates on top of `base`, fitted on the training trials.

    The search starts from no effect, with shape parameters at their initial values. A term of `base` that is the same
    number as a candidate is left out. Deterministic.
    """
    candidates = problem.candidates()
    same = {(c.effect.name, c.where) for c in candidates}
    fixed_terms = tuple(t for t in base if (t.candidate.effect.name, t.candidate.where) not in same)

    def losses(shares: FloatArray, ids: tuple[str, ...]) -> FloatArray:
        return trial_losses(problem.residuals((*fixed_terms, *_terms(candidates, shares)), ids, "short_horizon"), scale)

    start = _start(candidates)
    if len(start) < 2:  # Less than CMA-ES takes.
        return losses(start, trials.test)
    rng = np.random.default_rng(_SEED)
    options = {
        "bounds": [0.0, 1.0],
        "maxfevals": min(_PER_PARAMETER * len(start), _MOST_ROLLOUTS),
        "randn": lambda *shape: rng.standard_normal(shape),
        "seed": np.nan,  # else it seeds the generator that everyone shares
        "verbose": -9,
    }
    import cma  # Takes a second, which `--quick` saves.

    strategy = cma.CMAEvolutionStrategy(start, _CMA_STEP, options)
    best, least = start, float(losses(start, trials.train).mean())
    while not strategy.stop():
        proposals = strategy.ask()
        train_losses = [float(losses(x, trials.train).mean()) for x in proposals]
        strategy.tell(proposals, train_losses)
        if min(train_losses) < least:
            best, least = proposals[int(np.argmin(train_losses))], min(train_losses)
    return losses(best, trials.test)


def _start(candidates: tuple[Candidate, ...]) -> FloatArray:
    """Shares of the bounds at which no effect acts."""
    shares = []
    for c in candidates:
        for name, (low, high) in c.bounds.items():
            value = c.start[name] if name in c.shapes else c.null[name]
            shares.append((value - low) / (high - low))
    return np.clip(np.array(shares), 0.0, 1.0)


def _terms(candidates: tuple[Candidate, ...], shares: FloatArray) -> Model:
    rest = iter(shares.tolist())
    return tuple(
        Term(c, {name: low + next(rest) * (high - low) for name, (low, high) in c.bounds.items()}) for c in candidates
    )
