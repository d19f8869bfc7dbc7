"""Backlash: play (rad, m) between drive and joint, which the drive crosses after a reversal."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import EffortMap, JointState, Params
from sim.effects.candidacy import Bounds, MechanismCandidacy, Values
from sim.effects.effect import Confusable, Effect, Parameter
from sim.effects.ranges import JointRanges

_NARROWEST, _TYPICAL, _WIDEST = 5e-3, 0.1, 0.5  # gap over the range that was reached
_HEAVIEST_DRIVE = 0.2  # of the inertia that a drive moves
_FAST = 1e-9  # kg m2 (kg): a drive so light crosses at once
_STANDSTILL_S = 1e-9  # rows may share a stamp


def _map(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    """Effort passes while the drive leans on a flank; across the gap it gathers way, and gives it up where it lands.

    Landing is plastic and may be anywhere in a step: what passes is divided between this step and the next so that
    momentum and its mean time are right.
    """
    half, dt_s = 0.5 * params["gap_rad"], max(state.dt_s, _STANDSTILL_S)
    inertia = max(params["gap_inertia_kgm2rad"] / params["gap_rad"], _FAST)
    if not memory:
        play = half * np.sign(state.effort)  # drive minus joint
        memory.update(play=play, rate=state.qd, led=state.qd, deferred=np.zeros_like(state.effort))
    play, rate, deferred = memory["play"], memory["rate"], memory["deferred"]
    # To keep up with the joint; one that was just struck was no faster before.
    needed = inertia * (state.qd - memory["led"]) / dt_s
    needed = np.where(np.isnan(needed), 0.0, needed)
    in_contact = (np.abs(play) >= half) & (play * (state.effort - needed) >= 0.0)
    free = np.where(in_contact, state.qd, rate + state.effort * dt_s / inertia)
    relative_travel = (0.5 * (rate + free) - state.qd) * dt_s
    closes_gap = (np.abs(play + relative_travel) >= half) & ~in_contact & (relative_travel != 0.0)
    share = (np.copysign(half, relative_travel) - play) / np.where(closes_gap, relative_travel, 1.0)
    share = np.minimum(np.maximum(share, 0.0), 1.0)  # of the step, before it
    passed = np.where(closes_gap, inertia * (free - state.qd) / dt_s, 0.0)
    contact_effort = state.effort * (1.0 - share)
    later = np.where(
        closes_gap, (passed - contact_effort) * share + 0.5 * contact_effort * (1.0 + share) - 0.5 * passed, 0.0
    )
    memory["play"] = np.where(in_contact, play, np.minimum(np.maximum(play + relative_travel, -half), half))
    memory["rate"] = np.where(closes_gap, state.qd, free)
    memory["led"] = np.where(in_contact & (deferred == 0.0), state.qd, np.nan)
    memory["deferred"] = later
    return deferred + np.where(in_contact, state.effort, passed - later)


def _bounds(r: JointRanges) -> Bounds:
    return {
        "gap_inertia_kgm2rad": (0.0, _HEAVIEST_DRIVE * _WIDEST * r.span * r.inertia),
        "gap_rad": (_NARROWEST * r.span, _WIDEST * r.span),
    }


def _starts(r: JointRanges, null: Values, bounds: Bounds) -> tuple[Values, ...]:
    widest, heaviest = bounds["gap_rad"][1], bounds["gap_inertia_kgm2rad"][1]
    return tuple(
        {"gap_rad": share * widest, "gap_inertia_kgm2rad": part * heaviest}
        for share in (0.05, 0.3)
        for part in (0.0005, 0.002, 0.008, 0.03, 0.12, 0.4)
    )


EFFECT = Effect(
    name="joint.backlash",
    kinds=("mechanism",),
    formula="after a reversal the drive crosses gap_rad by itself, of inertia gap_inertia_kgm2rad / gap_rad",
    source="Nordin and Gutman, Automatica 38(10), 2002 (two masses and a gap); plastic landing as in Moreau's stepping",
    reveals="after a reversal the joint waits, longest where effort is small, and is then struck",
    parameters=(
        # What a crossing costs: the joint lags by this over its inertia, however fast. Rebounds make it look smaller.
        Parameter("gap_inertia_kgm2rad", "kg m2 rad (kg m)", 0.0, 100.0, 0.0),
        Parameter("gap_rad", "rad (m)", 1e-6, 1.0, 0.01, is_shape=True),
    ),
    confusables=(
        Confusable("actuator.delay", "reverse at several speeds: a delay is a time, play is an angle"),
        Confusable("actuator.deadband", "hold a small steady effort: play passes it, a dead band does not"),
        Confusable("sensor.latency", "reverse at several speeds"),
        Confusable("actuator.lag", "reverse at several speeds: a lag is a time, play is an angle"),
    ),
    hook=EffortMap(_map),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.driven,
        bounds=_bounds,
        start=lambda r: {"gap_rad": _TYPICAL * r.span},
        extra_starts=_starts,
    ),
)
