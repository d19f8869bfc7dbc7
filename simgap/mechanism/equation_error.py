"""Direct estimates: which parameters balance the equations of motion on smoothed readings, without simulating.

The unexplained effort of a joint is its inverse dynamics minus everything that is modelled (Gautier and Khalil, IEEE
T-RA 6(3), 1990, for robots). Trials are clusters: errors within one are correlated (Liang and Zeger, Biometrika 73,
1986), and a parameter is tested by its spread over trials, not over samples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from schemas.model import FloatArray
from sim.effects.effect import EffortMap, JointFriction, JointState, JointTorque, Series
from sim.joint_dynamics import joint_dynamics
from sim.mechanism import MechanismModel
from simgap.mechanism.smooth import Smooth
from simgap.mechanism.terms import Applied, apply_terms
from simgap.problem import Candidate, DirectEstimate, Model, Term

_MOST_ROWS = 1500  # per trial
_SCAN = 9

Recovered = Callable[[Model], Sequence[tuple[Series, Smooth]]]


def estimate(
    declared: MechanismModel, candidate: Candidate, model: Model, recovered: Recovered
) -> DirectEstimate | None:
    """The candidate's parameters given the terms of `model`, whose own values are fitted along; None when singular."""
    free = [*(t.candidate for t in model), candidate]
    names = [(c, n) for c in free for n in c.null]
    low = np.array([c.bounds[n][0] for c, n in names])
    high = np.array([c.bounds[n][1] for c, n in names])
    given = {t.candidate.key: t.values for t in model}
    start = np.array([given.get(c.key, c.start)[n] for c, n in names])

    def terms(x: FloatArray) -> Model:
        values: dict[str, dict[str, float]] = {c.key: {} for c in free}
        for (c, n), v in zip(names, x, strict=True):
            values[c.key][n] = float(v)
        return tuple(Term(c, values[c.key]) for c in free)

    def errors(x: FloatArray) -> list[FloatArray]:
        at = terms(x)
        applied = apply_terms(declared, at)
        return [unexplained(applied, series, smoothed) for series, smoothed in recovered(at)]

    base = errors(np.clip(start, low, high))
    level = 1.4826 * np.median(np.abs(np.concatenate([e.ravel() for e in base]))) + 1e-12

    def vector(share: FloatArray) -> FloatArray:
        return np.concatenate([(e / level).ravel() for e in errors(low + share * (high - low))])

    first = np.clip((start - low) / (high - low), 1e-3, 1.0 - 1e-3)
    own = [i for i, (c, _) in enumerate(names) if c is candidate]
    tries = [first]
    for i in own:
        for share in np.linspace(0.02, 0.98, _SCAN):
            tried = first.copy()
            tried[i] = share
            tries.append(tried)
    begin = min(tries, key=lambda s: float(np.log1p(vector(s) ** 2).sum()))
    solved = least_squares(
        vector, begin, bounds=(0.0, 1.0), loss="soft_l1", diff_step=1e-3, max_nfev=30, xtol=1e-6, ftol=1e-7
    )
    return _tested(solved.x, np.asarray(solved.jac), solved.fun, [e.size for e in base], own, names, low, high)


def _tested(
    share: FloatArray,
    jac: FloatArray,
    error: FloatArray,
    sizes: Sequence[int],
    own: Sequence[int],
    names: Sequence[tuple[Candidate, str]],
    low: FloatArray,
    high: FloatArray,
) -> DirectEstimate | None:
    """Values with standard errors over trials, and the p-value of the first parameter being at its null."""
    weight = 1.0 / np.sqrt(1.0 + error**2)
    bread = np.linalg.pinv((weight[:, None] * jac).T @ jac, rcond=1e-10)
    scores = np.stack([s.sum(axis=0) for s in np.split(weight[:, None] * jac * error[:, None], np.cumsum(sizes)[:-1])])
    clusters = len(sizes)
    if clusters < 2:
        return None
    cover = bread @ (scores.T @ scores * clusters / (clusters - 1)) @ bread
    deviation = np.sqrt(np.maximum(np.diag(cover), 0.0)) * (high - low)
    values = low + share * (high - low)
    strength = own[0]
    candidate, name = names[strength]
    if not deviation[strength] > 0.0:
        return None
    t = (values[strength] - candidate.null[name]) / deviation[strength]
    p = 2.0 * float(stats.t.sf(abs(t), clusters - 1))
    return DirectEstimate(
        {names[i][1]: float(values[i]) for i in own},
        {names[i][1]: float(deviation[i]) for i in own},
        p,
        clusters,
    )


def unexplained(applied: Applied, series: Series, smoothed: Smooth) -> FloatArray:
    """Effort (n, j) that the model cannot account for at the rows of a trial, N m or N.

    Near standstill dry friction can take any value: the error there is only what exceeds it.
    """
    mechanism = applied.mechanism
    thin = np.s_[:: max(1, len(series.t_s) // _MOST_ROWS)]
    q, qd, qdd = smoothed.q[thin], smoothed.qd[thin], smoothed.qdd[thin]
    sent = applied.sent(series)
    needed, load = joint_dynamics(mechanism.tree, mechanism.gravity_W).needed(q, qd, qdd)
    given = _given(mechanism, sent, thin, q, qd)
    aux = {n[4:]: v[thin] for n, v in sent.columns.items() if n.startswith("aux:")}
    step = float(np.median(np.diff(series.t_s)))
    stamps = series.t_s[thin][:, None]
    passive = -mechanism.damping * qd
    largest = {d: np.broadcast_to(mechanism.friction, q.shape).copy() for d in (-1.0, 1.0)}
    for law in applied.laws:
        one = np.s_[:, law.joint : law.joint + 1]
        state = JointState(stamps, q[one], qd[one], given[one], load[one], step, aux)
        if isinstance(law.hook, EffortMap):
            given[one] = law.hook.map(state, law.params, {})
        elif isinstance(law.hook, JointTorque):
            passive[one] += law.hook.torque(state, law.params, {})
        elif isinstance(law.hook, JointFriction):
            for d, limit in largest.items():
                limit[one] += law.hook.limit(state, law.params, np.full_like(q[one], d))
    rest = needed - given - passive
    return rest + _friction(rest, qd, largest, smoothed.qd_noise)


def _given(mechanism: MechanismModel, sent: Series, thin: slice, q: FloatArray, qd: FloatArray) -> FloatArray:
    drive = mechanism.drive
    if drive.type == "effort":
        asked = sent.columns["effort"][thin] * drive.effort_per_unit
    elif drive.type == "position_pd":
        asked = (drive.kp * (sent.columns["command"][thin] - q) - drive.kd * qd) * drive.effort_per_unit
    else:
        return np.zeros_like(q)
    return asked.copy() if drive.effort_limit is None else np.clip(asked, -drive.effort_limit, drive.effort_limit)


def _friction(rest: FloatArray, qd: FloatArray, largest: dict[float, FloatArray], qd_noise: FloatArray) -> FloatArray:
    """Dry friction to add to the needed effort: the full limit when moving, whatever is needed when not."""
    moving = np.abs(qd) > 3.0 * qd_noise
    forward = np.maximum(largest[1.0], 0.0)
    backward = np.maximum(largest[-1.0], 0.0)
    sliding = np.where(qd > 0, forward, -backward)
    sticking = np.clip(-rest, -backward, forward)
    return np.where(moving, sliding, sticking)
