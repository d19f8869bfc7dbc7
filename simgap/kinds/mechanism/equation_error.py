"""Direct estimates by equation error: parameters that balance the equations of motion on smoothed readings.

The unexplained effort of a joint is its inverse dynamics minus everything that is modelled (Gautier and Khalil, IEEE
T-RA 6(3), 1990, for robots), averaged over short blocks: a balance of momentum, in which the noise of accelerations
cancels. It is judged as the acceleration that it stands for: a lighter mechanism with weaker forces moves alike, but
its efforts are smaller, noise and all. A parameter is tested as on roll-outs, by trials held out in turn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse

from schemas.arrays import FloatArray, IntArray
from sim.dynamics.hooks import (
    EffortMap,
    JointFriction,
    JointState,
    JointTorque,
    Series,
    fresh_memory,
    step_value,
)
from sim.dynamics.joint_dynamics import Configuration, joint_dynamics
from sim.dynamics.mechanism import SUPPLY, Drive, Law, MechanismModel
from sim.effects.common.series import with_columns
from simgap.inference.fit import Errors, Fit, extend, fit, promising_starts, resampling_units
from simgap.inference.losses import paired_p, paired_p_where_affected
from simgap.kinds.mechanism.apply_model import Applied, apply_terms
from simgap.kinds.mechanism.logs import Log
from simgap.problem import Candidate, DirectEstimate, Model

BLOCKS = 0  # a span: stretches of one local cubic, side by side, all rows alike
SPANS = (BLOCKS, 4, 8)  # in local cubics
_FADE = 4  # power of a half sine
_SLOW = 3.0  # noise levels of a rate up to which a joint may stand


def balance(
    declared: MechanismModel, logs: Sequence[Log], spans: Sequence[int] = (BLOCKS,)
) -> Callable[[Model], list[list[FloatArray]]]:
    """Unexplained acceleration of any model, rad/s2 or m/s2: per span, per trial (b, j); b over averages."""

    return _averaged(declared, logs, spans, unexplained_acceleration)


def effort_balance(declared: MechanismModel, logs: Sequence[Log]) -> Callable[[Model], list[FloatArray]]:
    """Unexplained effort of any model, N m or N: per trial (b, j); b over stretches of one local cubic side by side."""
    errors = _averaged(declared, logs, (BLOCKS,), lambda applied, rows: _unexplained(applied, rows)[0])
    return lambda model: errors(model)[0]


def unexplained_acceleration(applied: Applied, rows: Rows) -> FloatArray:
    """Acceleration (n, j) of each row that the model cannot account for, in units of the readings; rad/s2 or m/s2."""
    effort, posture = _unexplained(applied, rows)
    return _freed(posture, effort) / rows.magnified


def sliding_acceleration(applied: Applied, rows: Rows) -> tuple[FloatArray, FloatArray]:
    """The same with the friction of sliding at every row; and by how much (n, j) friction may be less at each row.

    It may where a joint may stand. To take whatever friction is needed there would leave nothing of the noise on one
    side, and some of it on the other: on average a force against the motion.
    """
    rest, largest, posture = _beside_friction(applied, rows)
    qd = rows.columns["qd"]
    forward, backward = (np.maximum(largest[d], 0.0) for d in (1.0, -1.0))
    standing = np.where(np.abs(qd) > _SLOW * rows.qd_noise, 0.0, forward + backward)
    slid = _freed(posture, rest + np.where(qd > 0, forward, -backward))
    return slid / rows.magnified, np.abs(_freed(posture, standing)) / rows.magnified


def _freed(posture: Configuration, effort: FloatArray) -> FloatArray:
    """Accelerations (n, j) that efforts alone would give."""
    still = np.zeros_like(effort)
    return posture.free_rates(still, effort, still[0], np.ones((len(effort), 1)))


def rows_of(declared: MechanismModel, logs: Sequence[Log]) -> Callable[[Model], tuple[Applied, Rows]]:
    """The mechanism of any model, with the rows of all logs as it maps inputs and readings."""
    last: dict[object, Rows] = {}  # slopes of other terms leave readings and inputs as they are

    def rows(model: Model) -> tuple[Applied, Rows]:
        applied = apply_terms(declared, model)
        if applied.maps not in last:
            last.clear()
            last[applied.maps] = _rows(logs, applied)
        return applied, last[applied.maps]

    return rows


def _averaged(
    declared: MechanismModel,
    logs: Sequence[Log],
    spans: Sequence[int],
    quantity: Callable[[Applied, Rows], FloatArray],
) -> Callable[[Model], list[list[FloatArray]]]:
    """Averages of a quantity (n, j) of all rows: per span, per trial (b, j)."""
    logs = [inner(log) for log in logs]
    averages = tuple(_averages(logs, span) for span in spans)
    rows = rows_of(declared, logs)

    def errors(model: Model) -> list[list[FloatArray]]:
        rest = quantity(*rows(model))
        return [np.split(a.matrix @ rest, a.ends) for a in averages]

    return errors


def in_noise_levels(unexplained: Callable[[Model], list[list[FloatArray]]], model: Model) -> Errors:
    """The balance over what is typically left of `model`, span by span and joint by joint."""
    levels = [1.4826 * np.median(np.abs(np.concatenate(e)), axis=0) + 1e-12 for e in unexplained(model)]

    def errors(at: Model) -> list[FloatArray]:
        by_span = [[e / level for e in one] for one, level in zip(unexplained(at), levels, strict=True)]
        return resampling_units([np.concatenate(trial) for trial in zip(*by_span, strict=True)])

    return errors


def estimate(errors: Errors, base: Fit, candidate: Candidate) -> DirectEstimate | None:
    """The candidate's parameters, the terms of `base` refitted along; None where it leaves no trace or one trial."""
    if len(base.losses) < 2:
        return None
    fitted = extend(errors, base, candidate, promising_starts(errors, base, candidate))
    own_columns = fitted.solution.jac[:, -len(candidate.null) :]
    if not (np.abs(own_columns) > 1e-9).any():
        return None
    widths = fitted.half_widths[candidate.key]
    return DirectEstimate(
        dict(fitted.model[-1].values),
        {name: width / 1.96 for name, width in widths.items()},
        (paired_p_where_affected if candidate.extra_starts else paired_p)(base.held_out, fitted.held_out),
        len(base.losses),
        fitted.held_out,
    )


def refitted(errors: Errors, model: Model) -> Fit:
    """The terms of a model fitted to the balance."""
    return fit(errors, [replace(t.candidate, start=t.values) for t in model])


@dataclass(frozen=True)
class Rows:
    """All rows of all trials below one another, and their blocks.

    spans       of the trials, in rows.
    magnified   (n, j) how much larger accelerations (and their noise) are than as read.
    passed      by drive law, its last request, with which values, and what passed: slopes of other terms need
                the same again.
    """

    t_s: FloatArray
    columns: dict[str, FloatArray]
    qd_noise: FloatArray
    magnified: FloatArray
    step_s: float
    spans: tuple[tuple[int, int], ...]
    passed: dict[int, tuple[Law, FloatArray, FloatArray]] = field(default_factory=dict)


@dataclass(frozen=True)
class _Averages:
    """Weighted means over stretches of rows: `matrix` (b, n), and `ends` (t-1,) of the trials among them."""

    matrix: sparse.csr_array
    ends: IntArray


def inner(log: Log) -> Log:
    """Without the ends, where derivatives are one-sided, if enough is left."""
    m = log.margin
    if len(log.series.t_s) < 4 * m:
        return log
    columns = {n: v[m:-m] for n, v in log.series.columns.items()}
    return replace(log, series=Series(log.series.t_s[m:-m], columns))


def _rows(logs: Sequence[Log], applied: Applied) -> Rows:
    series = [_centred(applied.sent(applied.recovered(log.series))) for log in logs]
    lengths = [len(s.t_s) for s in series]
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    magnified = [
        np.broadcast_to(_rms(s.columns["qdd"]) / _rms(log.series.columns["qdd"]), (n, len(log.smooth.qd_noise)))
        for s, log, n in zip(series, logs, lengths, strict=True)
    ]
    return Rows(
        t_s=np.concatenate([s.t_s for s in series]),
        columns={n: np.concatenate([s.columns[n] for s in series]) for n in series[0].columns},
        qd_noise=np.concatenate([np.tile(log.smooth.qd_noise, (n, 1)) for log, n in zip(logs, lengths, strict=True)]),
        magnified=np.concatenate(magnified),
        step_s=float(np.median(np.concatenate([np.diff(s.t_s) for s in series]))),
        spans=tuple(zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True)),
    )


def _averages(logs: Sequence[Log], span: int) -> _Averages:
    counts = [len(log.series.t_s) for log in logs]
    by_trial = [
        _plain_means(n, log.block) if span == BLOCKS else smooth_means(n, min(span * log.block, n))
        for n, log in zip(counts, logs, strict=True)
    ]
    ends = np.cumsum([len(m.indptr) - 1 for m in by_trial])[:-1]
    return _Averages(sparse.csr_array(sparse.block_diag(by_trial)), ends)


def _plain_means(count: int, block: int) -> sparse.csr_array:
    """Means (b, count) over stretches side by side; the last takes what is left."""
    starts = np.arange(0, max(count - block // 2, 1), block)
    lengths = np.diff(np.append(starts, count))
    weights = np.repeat(1.0 / lengths, lengths)
    return sparse.csr_array((weights, np.arange(count), np.append(starts, count)), shape=(len(starts), count))


def smooth_means(count: int, rows: int) -> sparse.csr_array:
    """Means (b, count) over stretches that overlap by half, with weights that fade at both ends.

    The noise of an acceleration is that of readings, derived twice: a smooth weight takes the derivatives over, and
    the noise of a mean falls with the fifth power of the root of its length.
    """
    starts = np.arange(0, count - rows + 1, max(rows // 2, 1))
    columns = starts[:, None] + np.arange(rows)
    weights = np.sin(np.pi * (np.arange(rows) + 0.5) / rows) ** _FADE
    weights = np.tile(weights / weights.sum(), len(starts))
    ends = np.arange(0, weights.size + 1, rows)
    return sparse.csr_array((weights, columns.ravel(), ends), shape=(len(starts), count))


def _centred(series: Series) -> Series:
    """Inputs as they act around each stamp: held from row to row, half of what acts there was sent a row before."""
    return with_columns(series, ("effort", "command"), _mean_with_row_before)


def _mean_with_row_before(sent: FloatArray) -> FloatArray:
    return 0.5 * (sent + np.concatenate([sent[:1], sent[:-1]]))


def _rms(values: FloatArray) -> FloatArray:
    return np.sqrt((values**2).mean(axis=0)) + 1e-12


def _unexplained(applied: Applied, rows: Rows) -> tuple[FloatArray, Configuration]:
    """Effort (n, j) that the model cannot account for at each row, and the postures there.

    Near standstill dry friction can take any value: the error there is only what exceeds it.
    """
    rest, largest, posture = _beside_friction(applied, rows)
    return rest + _friction(rest, rows.columns["qd"], largest, rows.qd_noise), posture


def _beside_friction(applied: Applied, rows: Rows) -> tuple[FloatArray, dict[float, FloatArray], Configuration]:
    """Effort (n, j) that the model beside dry friction leaves, the largest friction by direction, and the postures."""
    mechanism = applied.mechanism
    q, qd = rows.columns["q"], rows.columns["qd"]
    posture = joint_dynamics(mechanism.tree, mechanism.gravity_W).at(q)
    required_effort = posture.required_effort(qd, rows.columns["qdd"])
    by_load = any(isinstance(law.hook, JointFriction) and law.hook.by_load for law in applied.laws)
    load = posture.load(qd) if by_load else np.full_like(q, np.nan)
    given = _given(mechanism.drive, rows.columns, q, qd)
    supply_V = rows.columns.get(f"aux:{SUPPLY}", np.full((len(q), 1), np.nan))
    passive = -mechanism.damping * qd
    largest = {d: np.broadcast_to(mechanism.friction, q.shape).copy() for d in (-1.0, 1.0)}
    for number, law in enumerate(applied.laws):
        one = np.s_[:, law.joint : law.joint + 1]
        state = JointState(rows.t_s[:, None], q[one], qd[one], given[one], rows.step_s, load[one], supply_V=supply_V)
        if isinstance(law.hook, EffortMap):
            last = rows.passed.get(number)
            if last is None or last[0] != law or not np.array_equal(last[1], state.effort):
                rows.passed[number] = last = law, state.effort.copy(), _mapped(law.hook, law, state, rows.spans)
            given[one] = last[2]
        elif isinstance(law.hook, JointTorque):
            passive[one] += step_value(law.hook, state, law.params, fresh_memory(law.hook, q[one].shape))
        elif isinstance(law.hook, JointFriction):
            for d, limit in largest.items():
                now = state._replace(friction=limit[one], direction=d)
                limit[one] += step_value(law.hook, now, law.params, fresh_memory(law.hook, q[one].shape))
    return required_effort - given - passive, largest, posture


def _mapped(hook: EffortMap, law: Law, state: JointState, spans: Sequence[tuple[int, int]]) -> FloatArray:
    """Effort that a drive gives row by row; a drive that remembers is led through each trial in time, all at once."""
    at_once = step_value(hook, state, law.params, fresh_memory(hook, state.q.shape))
    if not hook.memory:
        return at_once
    longest = max(b - a for a, b in spans)
    rows = np.stack([np.minimum(np.arange(a, a + longest), b - 1) for a, b in spans])  # the last row is held
    memory, out = fresh_memory(hook, (len(spans), 1)), at_once.copy()
    for k in range(longest):
        r = rows[:, k]
        now = JointState(state.t_s[r], state.q[r], state.qd[r], state.effort[r], state.dt_s, supply_V=state.supply_V[r])
        out[r] = step_value(hook, now, law.params, memory)
    return out


def _given(drive: Drive, columns: dict[str, FloatArray], q: FloatArray, qd: FloatArray) -> FloatArray:
    if drive.type == "effort":
        requested = columns["effort"] * drive.effort_per_unit
    elif drive.type == "position_pd":
        requested = (drive.kp * (columns["command"] - q) - drive.kd * qd) * drive.effort_per_unit
    else:
        return np.zeros_like(q)
    return (
        requested.copy() if drive.effort_limit is None else np.clip(requested, -drive.effort_limit, drive.effort_limit)
    )


def _friction(rest: FloatArray, qd: FloatArray, largest: dict[float, FloatArray], qd_noise: FloatArray) -> FloatArray:
    """Dry friction to add to the needed effort: the full limit when moving, whatever is needed when not."""
    moving = np.abs(qd) > _SLOW * qd_noise
    forward = np.maximum(largest[1.0], 0.0)
    backward = np.maximum(largest[-1.0], 0.0)
    sliding = np.where(qd > 0, forward, -backward)
    sticking = np.clip(-rest, -backward, forward)
    return np.where(moving, sliding, sticking)
