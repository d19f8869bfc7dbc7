"""How strong an effect must be: by what a perfect model would gain on the same trials, never by its unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from simgap.inference.fit import fit, robust_scale, rollout_errors
from simgap.inference.losses import paired_p, trial_losses
from simgap.kinds.mechanism.problem import MechanismProblem
from simgap.kinds.mechanism.whole_trials import MechanismTrials
from simgap.problem import Problem
from simgap.whole_trials.ladder import ladder_of
from simgap.whole_trials.policy import POLICY

GAINS = {"small": 0.02, "middle": 0.10, "large": 0.40}  # shares of the null refit's rms error
_TRIES = 7
_NEAR = 0.15  # relative miss of the aim that is good enough


def size_of(gain: float) -> str:
    """The size whose gain is nearest, by logarithms: the limits of a joint may keep a case from what was aimed at."""
    return min(GAINS, key=lambda size: abs(np.log(max(gain, 1e-6) / GAINS[size])))


def null_error(problem: Problem, scale: np.ndarray | None = None) -> tuple[float, np.ndarray]:
    """Root of the null refit's mean loss over all trials, in levels `scale` (c,; default: what it leaves itself)."""
    ids = problem.trial_ids
    null_fit = fit(rollout_errors(problem, ids, robust_scale(problem, (), ids)), problem.nuisances())
    level = robust_scale(problem, null_fit.model, ids) if scale is None else scale
    losses = trial_losses(problem.residuals(null_fit.model, ids, "short_horizon"), level)
    return float(np.sqrt(losses.mean())), level


def ideal_gain(hidden: Problem, plain: Problem) -> float:
    """1 - error without the effect / error with it, both after the null refit; noise and inputs are the same."""
    without, level = null_error(plain)
    return 1.0 - without / max(null_error(hidden, level)[0], 1e-12)


def sized(problem_at: Callable[[float], Problem], guess: float, most: float, aim: float) -> tuple[float, float]:
    """(strength, gain) at which a perfect model gains about `aim`; regula falsi on logarithms, at most `most`."""
    without, level = null_error(problem_at(0.0))
    target = np.log(1.0 / (1.0 - aim) ** 2 - 1.0)
    tried: list[tuple[float, float, float]] = []  # log strength, log of excess power, gain
    at, top = np.log(min(guess, most)), np.log(most)
    for _ in range(_TRIES):
        gain = 1.0 - without / max(null_error(problem_at(float(np.exp(at))), level)[0], 1e-12)
        tried.append((at, float(np.log(max(1.0 / (1.0 - gain) ** 2 - 1.0, 1e-6))), gain))
        if abs(gain - aim) < _NEAR * aim or (gain < aim and at >= top - 1e-9):
            break
        below = max((t for t in tried if t[2] < aim), default=None)
        above = min((t for t in tried if t[2] >= aim), default=None)
        if below is None or above is None:
            at = min(at + float(np.clip(0.5 * (target - tried[-1][1]), -2.0, 2.0)), top)
            continue
        # Between the two, where a straight line says; thresholds make that line a poor guide near its ends.
        share = float(np.clip((target - below[1]) / max(above[1] - below[1], 1e-9), 0.2, 0.8))
        at = below[0] + share * (above[0] - below[0])
    best = min(tried, key=lambda t: abs(t[2] - aim))
    return float(np.exp(best[0])), best[2]


def chance(hidden: MechanismProblem, plain: MechanismProblem, trials: Sequence[str]) -> float:
    """p-value of a perfect model against the null refit over whole training trials: Student's test over trials.

    Where an effect acts in one or two trials only, no test over trials can distinguish it from an accident of those,
    however much it does there.
    """
    without, level = _mean_squares(plain, trials, None)
    return paired_p(_mean_squares(hidden, trials, level)[0], without)


def _mean_squares(
    problem: MechanismProblem, trials: Sequence[str], level: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Mean square errors (t,) that the null refit leaves of whole trials, in levels (j,; default: its own noise)."""
    ladder = ladder_of(problem.whole_trials(trials), problem.nuisances(), POLICY)
    whole, null = ladder.whole, ladder.nulls[-1]
    assert isinstance(whole, MechanismTrials)
    level = whole.noise if level is None else level
    errors = whole.errors(null.model, null.starts[None])[0].reshape(len(null.starts), -1, whole.channel_count)
    squares = (errors * whole.noise / level) ** 2
    number = np.array([trial for trial, _ in whole.piece_starts])
    return np.array([np.nanmean(squares[number == k]) for k in range(len(trials))]), level
