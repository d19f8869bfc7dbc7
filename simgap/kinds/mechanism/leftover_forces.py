"""What a model of a mechanism leaves of the balance of forces, beside the states that a missing force may depend on.

From logs and a model to accelerations that it cannot account for, in noise levels. Nothing is rolled out: no start and
no earlier error enters.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from schemas.arrays import BoolArray, FloatArray
from sim.dynamics.joint_dynamics import joint_dynamics
from sim.dynamics.mechanism import MechanismModel
from simgap.kinds.mechanism.apply_model import Applied
from simgap.kinds.mechanism.equation_error import Rows, inner, rows_of, sliding_acceleration
from simgap.kinds.mechanism.logs import Log
from simgap.kinds.mechanism.weak_form import WeakMeans, mean_accelerations, means, weak_means
from simgap.problem import Leftover, Model, StateAxis
from simgap.whole_trials.parameter_space import Space, vector_of

_STRETCHES = (4, 8)  # lengths of stretches, in local cubics: shorter ones see fast states, longer ones small forces
_OUTLIER = 6.0  # noise levels at which single readings and impacts count no more
_MOST_DOUBTFUL = 0.5  # noise levels that friction at standstill may change a stretch that counts
_PASSES = 3  # of noise level, outliers and what counts
_FEWEST_STRETCHES = 20  # stretches: two in each bin
_LEAST_CHANGE = 1e-7  # share of the balance below which a parameter changes nothing
_LEAST_ROOM = 1e-3  # noise levels, over all stretches, that values at a bound may change beyond it

Balance = Callable[[Model], FloatArray]


def leftovers_of(declared: MechanismModel, logs: Sequence[Log], model: Model) -> tuple[Leftover, ...]:
    """The leftover of the model over stretches of each length that has enough of them."""
    logs = [inner(log) for log in logs]
    rows = rows_of(declared, logs)
    every = (_leftover(rows, logs, span, model) for span in _STRETCHES)
    return tuple(one for one in every if one is not None)


def _leftover(
    rows: Callable[[Model], tuple[Applied, Rows]], logs: Sequence[Log], span: int, model: Model
) -> Leftover | None:
    by_trial = [weak_means(log.series.t_s, span * log.block, log.block) for log in logs]
    applied, at = rows(model)
    base, doubtful = _weak(by_trial, applied, at)

    def unexplained(of: Model) -> FloatArray:
        return _weak(by_trial, *rows(of))[0]

    slopes = _slopes(unexplained, model, base)
    certain, noise, read = np.full(len(base), True), _spread(base), base
    for _ in range(_PASSES):
        left = slopes.least(read, certain, noise)
        read = base - noise * (left - np.clip(left, -_OUTLIER, _OUTLIER))
        noise = noise * _spread(left[certain])
        certain = np.asarray((doubtful < _MOST_DOUBTFUL * noise).all(axis=1))
        if np.count_nonzero(certain) < _FEWEST_STRETCHES:
            return None
    accelerations = mean_accelerations(by_trial, at.columns["q"] / at.magnified) - base
    own_parts: dict[str, FloatArray] = {}
    for term in model:
        if not term.candidate.nuisance:
            added = unexplained(tuple(t for t in model if t is not term)) - base
            key = term.candidate.key
            own_parts[key] = slopes.without(key).least(added, certain, noise, believed=False)[certain]
    return Leftover(
        values=slopes.least(read, certain, noise)[certain],
        own=own_parts,
        noise=noise,
        axes=_axes(lambda values: means(by_trial, values)[certain], applied, at, accelerations[certain], logs),
        forwards=means(by_trial, at.columns["qd"])[certain] > 0.0,
        trials=np.repeat(np.arange(len(logs)), [m.stretches for m in by_trial])[certain],
    )


def _spread(values: FloatArray) -> FloatArray:
    """(j,) robust standard deviations of values (b, j)."""
    return 1.4826 * np.median(np.abs(values - np.median(values, axis=0)), axis=0) + 1e-12


def _weak(by_trial: Sequence[WeakMeans], applied: Applied, rows: Rows) -> tuple[FloatArray, FloatArray]:
    """Unexplained acceleration (b, j): what is measured, by parts, less what the model gives at each row.

    And by how much friction may change it, where a joint may stand.
    """
    q, qdd = (rows.columns[n] / rows.magnified for n in ("q", "qdd"))
    unexplained, doubtful = sliding_acceleration(applied, rows)
    return mean_accelerations(by_trial, q) + means(by_trial, unexplained - qdd), means(by_trial, doubtful)


@dataclass(frozen=True)
class _Slopes:
    """Changes (b, j, p) of a balance with each of p parameters of terms by `keys`, and what is believed of these.

    offset      (p,) of the believed values from those at which the slopes were taken; `precision` of the belief.
    low, high   (p,) how far the parameters may move within their bounds.
    """

    keys: tuple[str, ...]
    columns: FloatArray
    offset: FloatArray
    precision: FloatArray
    low: FloatArray
    high: FloatArray

    def without(self, key: str) -> _Slopes:
        """Those of all other terms."""
        is_other = np.array([k != key for k in self.keys], dtype=bool)
        names = tuple(k for k in self.keys if k != key)
        by_parameter = (a[is_other] for a in (self.offset, self.precision, self.low, self.high))
        return _Slopes(names, self.columns[..., is_other], *by_parameter)

    def least(self, values: FloatArray, used: BoolArray, noise: FloatArray, *, believed: bool = True) -> FloatArray:
        """What stays of values (b, j), in noise levels (j,), when the parameters move to where least of the used does.

        They are held to what is `believed`, else to where they are.
        """
        levels, columns = values / noise, self.columns / noise[:, None]
        if not self.keys:
            return levels
        taught = columns[used].reshape(-1, len(self.keys))
        size = np.linalg.norm(taught, axis=0) + 1e-300
        hold = np.sqrt(self.precision) / size
        pull = hold * size * self.offset if believed else np.zeros(len(size))
        target = np.concatenate([-levels[used].ravel(), pull])
        within = (np.minimum(self.low * size, -_LEAST_ROOM), np.maximum(self.high * size, _LEAST_ROOM))
        moved = lsq_linear(np.vstack([taught / size, np.diag(hold)]), target, within).x
        return levels + columns @ (moved / size)


def _slopes(unexplained: Balance, model: Model, base: FloatArray) -> _Slopes:
    """Slopes of all parameters that are free, by differences towards the middle of their ranges."""
    space, vector = Space.of(model), vector_of(model)
    keys: list[str] = []
    columns: list[FloatArray] = []
    numbers: list[int] = []
    at = -1
    for place, term in enumerate(model):
        for name, value in term.values.items():
            at += 1
            low, high = term.candidate.bounds[name]
            step = term.candidate.step * (high - low) * (1.0 if value < 0.5 * (low + high) else -1.0)
            moved = replace(term, values={**term.values, name: value + step})
            change = unexplained((*model[:place], moved, *model[place + 1 :])) - base
            if step == 0.0 or not np.abs(change).max() > _LEAST_CHANGE * np.abs(base).max():
                continue
            keys.append(term.candidate.key)
            columns.append(change / step)
            numbers.append(at)
    matrix = np.stack(columns, axis=2) if columns else np.zeros((*base.shape, 0))
    return _Slopes(
        tuple(keys),
        matrix,
        (space.prior_mean - vector)[numbers],
        space.prior_precision[numbers],
        (space.low - vector)[numbers],
        (space.high - vector)[numbers],
    )


def _axes(
    mean: Callable[[FloatArray], FloatArray],
    applied: Applied,
    rows: Rows,
    accelerations: FloatArray,
    logs: Sequence[Log],
) -> tuple[StateAxis, ...]:
    """Position, velocity, acceleration, load, input, time and order; what friction may follow, by direction, too.

    The acceleration is that of the model: noise of the measured one is in what is left, too, and would repeat.
    """
    columns = rows.columns
    posture = joint_dynamics(applied.mechanism.tree, applied.mechanism.gravity_W).at(columns["q"])
    shape = accelerations.shape
    number = np.repeat(np.arange(len(logs), dtype=float), [len(log.series.t_s) for log in logs])
    since_s = np.concatenate([log.series.t_s - log.series.t_s[0] for log in logs])
    states = {
        "position": mean(columns["q"]),
        "load": mean(np.abs(posture.load(columns["qd"]))),
        "time": np.broadcast_to(mean(since_s[:, None]), shape),
    }
    if "command" in columns:
        states["input"] = mean(columns["command"] - columns["q"])
    elif "effort" in columns:
        states["input"] = mean(columns["effort"])
    plain = {"velocity": mean(columns["qd"]), "acceleration": accelerations, **states}
    turned = {**states, "order of trials": np.broadcast_to(mean(number[:, None]), shape)}
    return (
        *(StateAxis(words, values) for words, values in plain.items()),
        *(StateAxis(words, values, by_direction=True) for words, values in turned.items()),
    )
