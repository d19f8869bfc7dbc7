"""Whether what a model leaves of a balance repeats along a state, in trials apart: its size, chance, and visibility.

From leftovers to one `Structure` per axis and channel. Means in bins are multiplied between different trials, so that
noise, which does not repeat, gives none on average; signs of whole pieces of trials are flipped for the chance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.sim_gap.decisions import Reason
from simgap.inference.decision import Decision, criterion, decide
from simgap.problem import Leftover, StateAxis

_STATE_BINS = 10  # of equally many stretches; half as many for either direction
_FEWEST_PIECES = 20  # whose signs are flipped: so many give chances small enough for all axes together
_FLIPS = 4000
_SIGN_SEED = 0


@dataclass(frozen=True)
class Structure:
    """What repeats of a leftover along an axis.

    number      of the leftover, and its `channel`.
    size        rms over stretches of the mean that repeats, in noise levels; 0 where products are negative.
    p_value     of no structure, times the number of axes, channels and leftovers.
    visible     size from which a structure would have been significant.
    """

    words: str
    number: int
    channel: int
    size: float
    p_value: float
    visible: float


def structures(leftovers: Sequence[Leftover], alpha: float) -> tuple[Structure, ...]:
    """Along every axis of every leftover and channel, the most significant first; `visible` is at chance `alpha`."""
    tests = sum(len(one.axes) * one.values.shape[1] for one in leftovers)
    every_structure = [s for number, one in enumerate(leftovers) for s in _along_axes(one, number, tests, alpha)]
    return tuple(sorted(every_structure, key=lambda s: (s.p_value, -s.size)))


def shape_of(
    key: str, leftovers: Sequence[Leftover], every_structure: Sequence[Structure], alpha: float, share: float
) -> Decision:
    """Whether an effect's law has the shape of the force that it stands for; refused where another would fit as well.

    What the law alone explains is compared with what repeats although no values of the model's parameters explain it:
    the law must have at least the `share` of both, in squares. Where noise would hide a structure that matters, along
    every axis, the reason says so and the effect is not doubted.
    """
    if not every_structure:
        none = criterion("balances that are known in enough stretches", 0, "<=", 0)
        return decide([(Reason.PASSED, none)], Reason.SHAPE_HIDDEN)
    explained = [float((one.own[key] ** 2).sum(axis=1).mean()) for one in leftovers]
    of_seen = [(_share(explained[s.number], s.size), s) for s in every_structure if s.p_value < alpha]
    if of_seen:
        least, at = min(of_seen, key=lambda pair: pair[0])
        quantity = f"share of what repeats in the balance along {at.words} that the law explains"
        return decide([(Reason.SHAPE_DIFFERS, criterion(quantity, least, ">=", share))])
    smallest = max(_share(explained[s.number], s.visible) for s in every_structure)
    if smallest < share:
        quantity = "share that the law would explain beside the least structure that these trials show"
        return decide([(Reason.PASSED, criterion(quantity, smallest, "<", share))], Reason.SHAPE_HIDDEN)
    quantity = f"p-value of structure in the balance along {every_structure[0].words}"
    return decide([(Reason.SHAPE_DIFFERS, criterion(quantity, every_structure[0].p_value, ">=", alpha))])


def _share(explained: float, left: float) -> float:
    return explained / max(explained + left**2, 1e-300)


def _along_axes(leftover: Leftover, number: int, tests: int, alpha: float) -> Iterator[Structure]:
    pieces, trials = _pieces(leftover.trials)
    signs = np.random.default_rng(_SIGN_SEED).choice([-1.0, 1.0], size=(_FLIPS, len(trials)))
    apart = trials[:, None] != trials[None, :]
    for channel in range(leftover.values.shape[1]):
        values = leftover.values[:, channel]
        for axis in leftover.axes:
            bins = _bins(axis, leftover.forwards, channel)
            squares, by_chance = _products(values, bins, pieces, apart, signs)
            chance = (1.0 + np.count_nonzero(by_chance >= squares - 1e-12)) / (_FLIPS + 1.0)
            words = f"{axis.words} and direction" if axis.by_direction else axis.words
            visible = float(np.quantile(by_chance, 1.0 - alpha / tests))
            sizes = np.sqrt(np.maximum([squares, visible], 0.0))
            yield Structure(words, number, channel, float(sizes[0]), min(1.0, float(tests * chance)), float(sizes[1]))


def _products(
    values: FloatArray, bins: IntArray, pieces: IntArray, apart: BoolArray, signs: FloatArray
) -> tuple[float, FloatArray]:
    """Mean square of the bins' means that repeats between trials apart; and with flipped signs, (flips,).

    A product of means m1 m2 counts as often as there are stretches in the bin.
    """
    sums, counts = (np.zeros((len(apart), _STATE_BINS)) for _ in range(2))
    np.add.at(sums, (pieces, bins), values)
    np.add.at(counts, (pieces, bins), 1.0)
    pairs = np.einsum("ib,ij,jb->b", counts, apart, counts)
    weights = np.where(pairs > 0.0, counts.sum(axis=0) / np.maximum(pairs, 1.0), 0.0) / len(values)
    products = np.where(apart, (sums * weights) @ sums.T, 0.0)
    return float(products.sum()), ((signs @ products) * signs).sum(axis=1)


def _bins(axis: StateAxis, forwards: BoolArray, channel: int) -> IntArray:
    """(b,) bins of equally many stretches, from the lowest value up; those forwards after those backwards."""
    values = axis.values[:, channel]
    if not axis.by_direction:
        return _equal_counts(values, _STATE_BINS)
    return _equal_counts(values, _STATE_BINS // 2) + _STATE_BINS // 2 * forwards[:, channel]


def _equal_counts(values: FloatArray, bins: int) -> IntArray:
    return np.searchsorted(np.quantile(values, np.linspace(0.0, 1.0, bins + 1)[1:-1]), values, side="right")


def _pieces(trials: IntArray) -> tuple[IntArray, IntArray]:
    """(b,) piece of each stretch, and (pieces,) the trial of each: trials, cut where there are few."""
    numbers = np.unique(trials)
    cuts = -(-_FEWEST_PIECES // len(numbers))
    pieces, of_trial = np.zeros(len(trials), dtype=int), []
    for number in numbers:
        for part in np.array_split(np.flatnonzero(trials == number), cuts):
            pieces[part] = len(of_trial)
            of_trial.append(int(number))
    return pieces, np.array(of_trial)
