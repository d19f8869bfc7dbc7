"""Which library effects explain a hidden cause as well as itself: best refits, by the power of their difference.

Starts of segments are free, believed numbers are free within their tolerance, and the rival's own parameters are free
(Gauss-Newton, Jacobians by differences). What is left, summed in squared noise levels, is the noncentrality of a
likelihood ratio test between the two over all trials: below `SAME` these data cannot separate them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.causes.cause import Where
from tests.suites.gap2.generate.causes.library import LIBRARY
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden, Plant, Segment, Trial, read_segments
from tests.suites.gap2.generate.power import Readings, miss_by_trial
from tests.suites.gap2.generate.scenes import Recording

SAME = 9.0  # noncentrality at which the better of two equal causes is still taken for the other in 7 of 100 cases
CLOSE = 100.0  # to doubt between them is right up to here
TOLERANCE = 0.02  # of believed numbers, one standard deviation: controls are up to 3 % off
_TRIALS, _MOTION_S = 3, 6.0  # so many trials, and so long a motion (s), those that a cause moves most
_TIMING = 0.05  # of a row, one standard deviation: when an input meets the readings
_SEGMENT_S = 2.0
_ROUNDS = 8
_PROMISING = 0.7  # share of the signal that a rival must explain in the linear screening
_MOST_REFITTED = 6
_FIRST_MISS, _LEAST_SHARE = 5.0, 1e-3  # noise levels of a whole trial at the first share of the strength
_GROWTH = 3.0  # of that share from refit to refit
_LOST = 1e4  # noncentrality of belief beyond which its refit is followed no further
_STEP = 1e-3
_DIVERGED = 1e12  # noise levels per unit
_COARSER = 3.0  # steps than the truth's

Values = Array
Make = Callable[[Plant, Values], Hidden]
ReadingsAt = Callable[[float, Sequence[Trial]], Readings]


@dataclass(frozen=True)
class Rival:
    """What a rival leaves: its noncentrality beside the hidden cause, over all trials."""

    name: str
    noncentrality: float


def rivals_of(
    truth: Sequence[str], where: Where, recording: Recording, readings_at: ReadingsAt
) -> tuple[float, tuple[Rival, ...]]:
    """(noncentrality of the believed model after its own refit, promising rivals, nearest first).

    `readings_at` gives the noise-free readings of some trials with a share of the hidden strength. Refits begin at a
    share so small that a linear model holds and follow it to the whole, each from the one before; a refit that is
    separable on the way stays so, and its noncentrality there is a lower bound.
    """
    strong = miss_by_trial(
        where.plant,
        readings_at(1.0, recording.trials),
        recording.trials,
        recording.sigma,
        float("inf"),
        recording.step_s,
    )
    order = np.argsort(-strong, kind="stable")
    lengths = np.cumsum([float(np.ptp(recording.trials[i].stamps_s)) for i in order])
    some = sorted(order[: max(_TRIALS, int(np.searchsorted(lengths, _MOTION_S)) + 1)].tolist())
    all_trials = float(strong.sum() / max(strong[some].sum(), 1e-12))
    trials = [recording.trials[i] for i in some]
    rows = sum(len(t.stamps_s) for t in trials) * where.plant.joints
    first = float(np.clip(_FIRST_MISS / max(np.sqrt(strong[some].sum() / rows), 1e-9), _LEAST_SHARE, 1.0))

    def at(share: float) -> _Refit:
        return _Refit(where, trials, readings_at(share, trials), recording, all_trials, share)

    believed: Make = lambda plant, x: Hidden(where.joint)  # noqa: E731
    count = int(np.ceil(np.log(1.0 / first) / np.log(_GROWTH) - 1e-9)) + 1
    stages = [at(min(1.0, first * _GROWTH**k)) for k in range(count)]
    believed_fits = [stages[0].best(believed, 0)]
    shown = 0  # the first stage at which the cause is beyond the tolerance of believed numbers, and above thresholds
    for before, now in pairwise(stages):
        if believed_fits[-1].cost > _LOST:
            break
        grown = now.share / before.share
        believed_fits.append(now.best(believed, 0, before.carried(believed_fits[-1], now, grown)))
        shown = shown if believed_fits[shown].cost > CLOSE else len(believed_fits) - 1
    makers = _makers(where, any(np.ptp(t.supply) > 0.0 for t in trials))
    promising = stages[shown].screened({n: m for n, m in makers.items() if n not in truth}, believed_fits[shown])

    def followed(make: Make, count: int) -> float:
        last = stages[0].best(make, count)
        for k in range(1, len(stages)):
            grown = stages[k].share / stages[k - 1].share
            fit = stages[k].best(make, count, stages[k - 1].carried(last, stages[k], grown))
            null = believed_fits[min(k, len(believed_fits) - 1)]
            if k < len(believed_fits) and fit.cost > 0.5 * null.cost:  # every rival holds the believed model
                fit = min(
                    (fit, stages[k].best(make, count, (np.zeros(count), null.shares, list(null.starts)))),
                    key=lambda f: f.cost,
                )
            last = fit
            if last.cost > CLOSE:
                break
        return last.cost

    rivals = [Rival(name, min(believed_fits[-1].cost, followed(*makers[name]))) for name in promising]
    return believed_fits[-1].cost, tuple(sorted(rivals, key=lambda r: r.noncentrality))


def _makers(where: Where, supplied: bool) -> dict[str, tuple[Make, int]]:
    """How to make each rival that the columns can reveal, from its free values (zero: none), and their number."""
    plant, joint = where.plant, where.joint
    single = plant.joints == 1
    driven = plant.drive != "none"
    shown = {
        "joint.coulomb_friction": True,
        "joint.viscous_friction": True,
        "joint.stribeck_friction": single,
        "joint.load_dependent_friction": single and plant.upright,
        "joint.quadratic_drag": True,
        "joint.friction_asymmetry": where.believed(Number.COULOMB) > 0.0,
        "joint.axis_tilt": plant.upright,
        "joint.armature": True,
        "joint.gravity_load": plant.upright,
        "actuator.delay": driven,
        "actuator.lag": driven,
        "actuator.gain": driven,
        "actuator.bias": driven,
        "actuator.deadband": driven,
        "actuator.supply_sag": driven and supplied,
        "sensor.latency": driven,
        "sensor.lag": driven,
        "sensor.bias": plant.upright or driven,
        "sensor.scale": True,
        "sensor.clock_skew": True,
    }
    causes = {c.name: c for c in LIBRARY}
    one_sided = ("actuator.lag", "actuator.deadband", "sensor.lag")  # a delay may be negative: timing is a nuisance

    def of(name: str) -> Make:
        def make(believed: Plant, x: Values) -> Hidden:
            strength = max(x[0], 0.0) if name in one_sided else x[0]
            return causes[name].hidden(float(strength), replace(where, plant=believed, draws=np.full(4, 0.4)))

        return make

    makers: dict[str, tuple[Make, int]] = {name: (of(name), 1) for name, is_shown in shown.items() if is_shown}

    def spring(believed: Plant, x: Values) -> Hidden:
        soft = 1e-6 * where.sizes.torque / where.sizes.reach
        stiffness = x[0] * where.sizes.torque / where.sizes.reach
        stiffness = soft if abs(stiffness) < soft else stiffness
        return Hidden(joint, {Number.SPRING: stiffness, Number.SPRING_REST: x[1] * where.sizes.torque / stiffness})

    def gains(believed: Plant, x: Values) -> Hidden:
        kp, kd = (believed.number(joint, n) for n in (Number.KP, Number.KD))
        return Hidden(joint, {Number.KP: kp * (1.0 + x[0]), Number.KD: kd * (1.0 + x[1])})

    makers["joint.spring"] = (spring, 2)
    if plant.drive == "position_pd":
        makers["robot.pd_gains"] = (gains, 2)
    return makers


@dataclass(frozen=True)
class _Fit:
    """Best values of a cause and of the nuisances, starts and errors by segment, and the squared noise levels left."""

    x: Values
    shares: Values
    starts: Sequence[Array]
    errors: Sequence[Array]
    cost: float


class _Refit:
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

    def carried(self, fit: _Fit, to: _Refit, grown: float) -> tuple[Values, Values, list[Array]]:
        """Values and starts of a fit here, carried over to readings with `grown` times the strength."""
        starts = [b + grown * (s - a) for s, a, b in zip(fit.starts, self.starts, to.starts, strict=True)]
        return grown * fit.x, grown * fit.shares, starts

    def best(self, make: Make, count: int, begin: tuple[Values, Values, list[Array]] | None = None) -> _Fit:
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
        return _Fit(x, shares, starts, at, cost)

    def screened(self, makers: dict[str, tuple[Make, int]], null: _Fit) -> list[str]:
        """Rivals that take most of what the null refit leaves, to first order, the best first."""
        none: Make = lambda plant, x: Hidden(self.where.joint)  # noqa: E731
        shares, starts, at = null.shares, null.starts, null.errors
        shared, by_start = self.jacobian(none, np.zeros(0), shares, starts, at)
        if not np.isfinite(null.cost):
            return []
        signal, basis = _projected(at, shares, shared, by_start)
        explained = {}
        for name, (make, count) in makers.items():
            columns: list[list[Array]] = [[] for _ in self.parts]
            for step in _STEP * np.eye(count):
                ahead, behind = self.errors(make, step, shares, starts), self.errors(make, -step, shares, starts)
                for part, a, b in zip(columns, ahead, behind, strict=True):
                    part.append((a - b) / (2.0 * _STEP))
            directions = np.stack([_without(by_start, [c[k] for c in columns], basis) for k in range(count)], axis=1)
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


def _free_of_starts(by_start: Sequence[Sequence[Array]], values: Sequence[Array]) -> Array:
    """Values by segment, each without what its own start explains, in one array."""
    out = []
    for columns, value in zip(by_start, values, strict=True):
        Q = np.linalg.qr(np.stack(columns, axis=1))[0]
        out.append(value - Q @ (Q.T @ value))
    return np.concatenate(out)


def _projected(at, shares: Values, shared, by_start) -> tuple[Array, Array]:
    """The errors without starts and nuisances, and an orthonormal basis of the nuisances; priors are the last rows."""
    count = len(shares)
    columns = [
        np.concatenate([_free_of_starts(by_start, [c[k] for c in shared]), (np.arange(count) == k) / TOLERANCE])
        for k in range(count)
    ]
    basis = np.linalg.qr(np.stack(columns, axis=1))[0]
    signal = np.concatenate([_free_of_starts(by_start, at), shares / TOLERANCE])
    return signal - basis @ (basis.T @ signal), basis


def _without(by_start, values: Sequence[Array], basis: Array) -> Array:
    value = np.concatenate([_free_of_starts(by_start, values), np.zeros(basis.shape[1])])
    return value - basis @ (basis.T @ value)


def gauss_newton(shared, by_start, at, shares: Values, count: int) -> tuple[Values, list[Array]]:
    """Step of the shared values and of each segment's start (in its own sizes)."""
    total = len(shared[0])
    rows, right = [], []
    for columns, starts, error in zip(shared, by_start, at, strict=True):
        Q = np.linalg.qr(np.stack(starts, axis=1))[0]
        J = np.stack(columns, axis=1) if total else np.zeros((len(error), 0))
        rows.append(J - Q @ (Q.T @ J))
        right.append(-(error - Q @ (Q.T @ error)))
    prior = np.zeros((total - count, total))
    prior[:, count:] = np.eye(total - count) / TOLERANCE
    J, b = np.concatenate([*rows, prior]), np.concatenate([*right, -shares / TOLERANCE])
    step = np.linalg.lstsq(J, b, rcond=1e-9)[0] if total else np.zeros(0)
    moves = []
    for columns, starts, error in zip(shared, by_start, at, strict=True):
        reached = error + (np.stack(columns, axis=1) @ step if total else 0.0)
        moves.append(np.linalg.lstsq(np.stack(starts, axis=1), -reached, rcond=1e-9)[0])
    return step, moves
