"""Candidate effects of a mechanism by joint, from the magnitudes in its logs; SI.

What an effect makes of the magnitudes (bounds, start, thresholds) is in the effect's own file; here they are measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import MechanismModel
from sim.dynamics.tree import inverse_dynamics, mass_matrix
from sim.effects.candidacy import ROLES
from sim.effects.effect import IN_LOOP, Effect
from sim.effects.library import EFFECTS
from sim.effects.ranges import DeclaredJoint, JointRanges
from simgap.problem import Candidate

_QUANTILE = 0.95
_AUX = "aux:"
_PINNED = 1e-6  # half width of the bounds of a fixed value


def ranges_of(model: MechanismModel, series: Sequence[Series], joint: int, step_s: float) -> JointRanges:
    """Magnitudes at a joint over all trials, from smoothed columns q, qd, qdd, rolled out in steps up to `step_s`."""
    q, qd, qdd = (np.concatenate([s.columns[n] for s in series]) for n in ("q", "qd", "qdd"))
    thin = np.s_[:: max(1, len(q) // 4000)]
    torque, load = inverse_dynamics(model.tree, q[thin], qd[thin], qdd[thin], model.gravity_W)
    inertia = float(np.median(mass_matrix(model.tree, q[thin])[:, joint, joint]))
    effort = _effort(model, series, joint)
    shared = set.intersection(*({n for n in s.columns if n.startswith(_AUX)} for s in series))
    return JointRanges(
        model=model,
        joint=joint,
        row_s=float(np.median(np.concatenate([np.diff(s.t_s) for s in series]))),
        torque=max(_size(torque[:, joint]), effort, 1e-9),
        speed=max(_size(qd[:, joint]), 1e-9),
        low=float(q[:, joint].min()),
        high=float(q[:, joint].max()),
        inertia=max(inertia, 1e-12),
        load=max(_size(load[:, joint]), 1e-9),
        effort=effort,
        side_channels={
            name.removeprefix(_AUX): float(np.median(np.concatenate([s.columns[name] for s in series])))
            for name in sorted(shared)
        },
        step_s=step_s,
    )


def _size(values: FloatArray) -> float:
    return float(np.quantile(np.abs(values), _QUANTILE))


def candidates_of(model: MechanismModel, series: Sequence[Series], step_s: float) -> tuple[Candidate, ...]:
    """Every effect of the library that these columns can reveal, at every joint, in library order.

    Roll-outs take steps of at most `step_s`, which bounds how stiff a law may be.
    """
    by_joint = [ranges_of(model, series, j, step_s) for j in range(len(model.tree))]
    return tuple(
        variant
        for each in EFFECTS
        if "mechanism" in each.kinds
        for ranges in (by_joint[:1] if each.mechanism.whole_log else by_joint)
        if each.mechanism.observable(ranges)
        for variant in _variants(_candidate(each, ranges), model.drive.type == "position_pd")
    )


def _variants(candidate: Candidate, has_feedback: bool) -> tuple[Candidate, ...]:
    """The candidate where it acts; for what may lie inside a loop, before and inside it."""
    if candidate.effect.in_loop is None:
        return (candidate,)
    before = _fixed(candidate, 0.0, "")
    return (before, _fixed(candidate, 1.0, "in loop")) if has_feedback else (before,)


def _fixed(candidate: Candidate, in_loop: float, variant: str) -> Candidate:
    value, bounds = {IN_LOOP.name: in_loop}, {IN_LOOP.name: (in_loop - _PINNED, in_loop + _PINNED)}
    return replace(
        candidate,
        null=candidate.null | value,
        start=candidate.start | value,
        bounds=candidate.bounds | bounds,
        variant=variant,
    )


def _candidate(each: Effect, ranges: JointRanges) -> Candidate:
    how = each.mechanism
    null = each.null() | how.null(ranges)
    wished = {p.name: (p.low, p.high) for p in each.parameters} | how.bounds(ranges)
    bounds = {}
    for p in each.parameters:
        low, high = wished[p.name]
        bounds[p.name] = (max(low, p.low), max(min(high, p.high), max(low, p.low) + 1e-12))
    start = null | how.start(ranges)
    return Candidate(
        each,
        Place() if how.whole_log else Place(joint=ranges.link.name),
        null,
        {n: float(np.clip(v, *bounds[n])) for n, v in start.items()},
        bounds,
        shapes=each.shapes,
        extra_starts=how.extra_starts(ranges, null, bounds),
        max_excursion=how.max_excursion(ranges),
    )


def nuisances_of(model: MechanismModel, row_s: float) -> tuple[Candidate, ...]:
    """Numbers of each joint that are believed within a tolerance, joint by joint."""
    out = []
    for joint in (DeclaredJoint(model, j, row_s) for j in range(len(model.tree))):
        known = [(e, n) for e in EFFECTS if "mechanism" in e.kinds and (n := e.mechanism.nuisance(joint)) is not None]
        for each, number in sorted(known, key=lambda pair: ROLES.index(pair[1].role)):
            value, bounds = {number.parameter: number.value}, {number.parameter: (number.low, number.high)}
            out.append(Candidate(each, Place(joint=joint.link.name), value, value, bounds, nuisance=True))
    return tuple(out)


def _effort(model: MechanismModel, series: Sequence[Series], joint: int) -> float:
    """Size of the effort commanded at a joint."""
    if model.drive.type == "effort":
        column, factor = "effort", abs(model.drive.effort_per_unit)
    elif model.drive.type == "position_pd":
        column, factor = "command", float(model.drive.kp[joint]) * abs(model.drive.effort_per_unit)
    else:
        return 0.0
    parts = [
        s.columns[column][:, joint] - (s.columns["q"][:, joint] if column == "command" else 0.0)
        for s in series
        if column in s.columns
    ]
    return factor * _size(np.concatenate(parts)) if parts else 0.0
