"""Refits a cause to the noise-free readings of a few trials: its values, nuisances and the starts of segments are free.

Gauss-Newton with Jacobians by differences; believed numbers and the inputs' timing are free within their tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.causes.cause import Where
from tests.suites.gap2.generate.least_squares import TOLERANCE, gauss_newton, without_basis, without_nuisances
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden, Plant, Segment, Trial, read_segments
from tests.suites.gap2.generate.power import Readings
from tests.suites.gap2.generate.scenes import Recording
from tests.suites.gap2.generate.truth import SAME

_TIMING = 0.05  # of a row, one standard deviation: when an input meets the readings
_SEGMENT_S = 2.0
_ROUNDS = 8
_PROMISING = 0.7  # share of the signal that a rival must explain in the linear screening
_MOST_REFITTED = 6
_STEP = 1e-3
_DIVERGED = 1e12  # noise levels per unit
_COARSER = 3.0  # steps than the truth's

Values = Array
Make = Callable[[Plant, Values], Hidden]


@dataclass(frozen=True)
class Fit:
    """Best values of a cause and of the nuisances, starts and errors by segment, and the squared noise levels left."""

    x: Values
    shares: Values
    starts: Sequence[Array]
    errors: Sequence[Array]
    cost: float


class Refit:
    """Refits of causes to the noise-free readings of a few trials, in segments whose starts are free."""

    def __init__(
        self,
        where: Where,
        trials: Sequence[Trial],
        readings: Readings,
        recording: Recording,
        weight: float,
        share: float,
    ) -> None:
        self.where, self.trials, self.recording = where, trials, recording
        self.share = share
        self.sigma = recording.sigma / np.sqrt(weight)  # these trials stand for all
        self.parts: list[tuple[int, int, int]] = []
        self.starts: list[Array] = []
        span = max(_SEGMENT_S, 2.0 * recording.period_s)
        for i, (trial, (q, v)) in enumerate(zip(trials, readings, strict=True)):
            t = trial.stamps_s
            pieces = max(1, round((t[-1] - t[0]) / span))
            edges = np.searchsorted(t, np.linspace(t[0], t[-1] + 1e-6, pieces + 1))
            for first, last in pairwise(edges):
                self.parts.append((i, int(first), int(last)))
                self.starts.append(np.concatenate([q[first], v[first]]))
        self.truth = [readings[i][0][a:b] for i, a, b in self.parts]
        self.nuisances = self._nuisances()
        self.count = len(self.nuisances) + (where.plant.drive != "none")  # the last one is the inputs' timing
        self.row_s = float(np.median(np.diff(trials[0].stamps_s)))

    def _nuisances(self) -> list[Callable[[Plant, float], Plant]]:
        joint, plant = self.where.joint, self.where.plant

        def inertia(believed: Plant, share: float) -> Plant:
            scaled = believed.inertia.copy()
            scaled[joint] *= 1.0 + share
            return replace(believed, inertia=scaled)

        def number(which: Number) -> Callable[[Plant, float], Plant]:
            def changed(believed: Plant, share: float) -> Plant:
                numbers = believed.numbers.copy()
                numbers[joint, which] *= 1.0 + share
                return replace(believed, numbers=numbers)

            return changed

        shown = [Number.COULOMB, Number.VISCOUS]
        shown += [Number.GRAVITY_FACTOR] if plant.upright else []
        shown += [Number.GAIN] if plant.drive == "effort" else []
        shown += [Number.KP, Number.KD] if plant.drive == "position_pd" else []
        return [inertia, *(number(w) for w in shown if plant.number(joint, w) != 0.0)]

    def readings(self, make: Make, x: Values, shares: Values, starts: Sequence[Array]) -> list[Array]:
        """Predicted readings by segment."""
        plant = self.where.plant
        for change, share in zip(self.nuisances, shares, strict=False):
            plant = change(plant, float(share))
        hidden = make(plant, x)
        if self.count > len(self.nuisances):
            hidden = replace(hidden, delay_s=hidden.delay_s + _TIMING * self.row_s * float(shares[-1]) / TOLERANCE)
        segments = [
            Segment(i, a, b, start, float(self.trials[i].stamps_s[a]) / hidden.clock - hidden.latency_s)
            for (i, a, b), start in zip(self.parts, starts, strict=True)
        ]
        return [q for q, _ in read_segments(plant, hidden, self.trials, segments, _COARSER * self.recording.step_s)]

    def errors(self, make: Make, x: Values, shares: Values, starts: Sequence[Array]) -> list[Array]:
        """Prediction minus truth by segment, raveled, in noise levels."""
        predicted = self.readings(make, x, shares, starts)
        return [((p - t) / self.sigma).ravel() for p, t in zip(predicted, self.truth, strict=True)]

    def jacobian(
        self, make: Make, x: Values, shares: Values, starts: Sequence[Array], at: Sequence[Array]
    ) -> tuple[list[list[Array]], list[list[Array]]]:
        """Columns by segment of the shared values (x, then nuisances) and of the segment's own start."""
        shared: list[list[Array]] = [[] for _ in self.parts]
        by_start: list[list[Array]] = [[] for _ in self.parts]

        def add(to: list[list[Array]], ahead: Sequence[Array], behind: Sequence[Array]) -> None:
            for columns, a, b in zip(to, ahead, behind, strict=True):
                columns.append((a - b) / (2.0 * _STEP))

        # Central: one-sided differences err by more than the priors weigh where two values undo one another.
        for step in _STEP * np.eye(len(x)):
            add(shared, self.errors(make, x + step, shares, starts), self.errors(make, x - step, shares, starts))
        for step in _STEP * np.eye(len(shares)):
            add(shared, self.errors(make, x, shares + step, starts), self.errors(make, x, shares - step, starts))
        size = np.concatenate([np.full(self.where.plant.joints, self.where.sizes.reach)] * 2)
        size[self.where.plant.joints :] = self.where.sizes.speed
        for k in range(len(size)):
            move = 1e-4 * size * (np.arange(len(size)) == k)
            moved = self.errors(make, x, shares, [s + move for s in starts])
            for columns, a, b in zip(by_start, moved, at, strict=True):
                columns.append((a - b) / 1e-4)
        return shared, by_start

    def carried(self, fit: Fit, to: Refit, grown: float) -> tuple[Values, Values, list[Array]]:
        """Values and starts of a fit here, carried over to readings with `grown` times the strength."""
        starts = [b + grown * (s - a) for s, a, b in zip(fit.starts, self.starts, to.starts, strict=True)]
        return grown * fit.x, grown * fit.shares, starts

    def best(self, make: Make, count: int, begin: tuple[Values, Values, list[Array]] | None = None) -> Fit:
        """The best refit; priors of the nuisances count as errors."""
        x, shares, starts = begin or (np.zeros(count), np.zeros(self.count), list(self.starts))
        n = self.where.plant.joints
        size = np.concatenate([np.full(n, self.where.sizes.reach), np.full(n, self.where.sizes.speed)])
        at = self.errors(make, x, shares, starts)
        cost = _cost(at, shares)
        for _ in range(_ROUNDS):
            shared, by_start = self.jacobian(make, x, shares, starts, at)
            if not all(
                np.isfinite(c).all() and np.abs(c).max() < _DIVERGED for part in (*shared, *by_start) for c in part
            ):
                break
            step, moves = gauss_newton(shared, by_start, at, shares, count)
            for fraction in (1.0, 0.3, 0.1, 0.03):
                x_new, shares_new = x + fraction * step[:count], shares + fraction * step[count:]
                starts_new = [s + fraction * size * m for s, m in zip(starts, moves, strict=True)]
                at_new = self.errors(make, x_new, shares_new, starts_new)
                cost_new = _cost(at_new, shares_new)
                if cost_new < cost:
                    break
            else:
                break
            gained = cost - cost_new
            x, shares, starts, at, cost = x_new, shares_new, starts_new, at_new, cost_new
            if gained < 0.003 * cost or cost < 0.1 * SAME:
                break
        return Fit(x, shares, starts, at, cost)

    def screened(self, makers: dict[str, tuple[Make, int]], null: Fit) -> list[str]:
        """Rivals that take most of what the null refit leaves, to first order, the best first."""
        none: Make = lambda plant, x: Hidden(self.where.joint)  # noqa: E731
        shares, starts, at = null.shares, null.starts, null.errors
        shared, by_start = self.jacobian(none, np.zeros(0), shares, starts, at)
        if not np.isfinite(null.cost):
            return []
        signal, basis = without_nuisances(at, shares, shared, by_start)
        explained = {}
        for name, (make, count) in makers.items():
            columns: list[list[Array]] = [[] for _ in self.parts]
            for step in _STEP * np.eye(count):
                ahead, behind = self.errors(make, step, shares, starts), self.errors(make, -step, shares, starts)
                for part, a, b in zip(columns, ahead, behind, strict=True):
                    part.append((a - b) / (2.0 * _STEP))
            directions = np.stack(
                [without_basis(by_start, [c[k] for c in columns], basis) for k in range(count)], axis=1
            )
            if not np.isfinite(directions).all():
                continue
            fitted = directions @ np.linalg.lstsq(directions, signal, rcond=1e-9)[0]
            explained[name] = float(fitted @ signal) / max(float(signal @ signal), 1e-12)
        best = sorted((n for n, share in explained.items() if share > _PROMISING), key=lambda n: -explained[n])
        return best[:_MOST_REFITTED]


def _cost(errors: Sequence[Array], shares: Values) -> float:
    if any(not np.isfinite(e).all() or np.abs(e).max() > _DIVERGED for e in errors):
        return np.inf
    return sum(float(e @ e) for e in errors) + float(((shares / TOLERANCE) ** 2).sum())
