"""Candidate effects of a mechanism by joint, with bounds from the magnitudes in its logs; SI.

Bounds follow from the log itself: torques of the size that moved the joint, speeds and positions that were reached.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.gap import Place
from sim.dynamics.hooks import Effect, Series
from sim.dynamics.mechanism import MechanismModel
from sim.dynamics.tree import inverse_dynamics, mass_matrix
from sim.effects.library import EFFECTS, effect
from simgap.problem import Candidate

_QUANTILE = 0.95
# Declared numbers are believed to this share; what lies within is a nuisance, not an effect.
TOLERANCE = 0.05
MEETING = 0.1  # of a row: how well the time is known at which an input acts
_REPEATED = 3.0  # half waves within the range that was reached, below which nothing repeats: springs and weights do so
_STOP_SHARES = (0.01, 0.03, 0.07, 0.13, 0.22, 0.33)
_STIFFEST = 0.3  # of inertia over a step's square: what is stiffer would throw a joint out faster than it came
_STEP_S = 5e-3
_MOST_LOSS = 3.0  # of a stop's force on the way in beyond that at rest, at the speeds that were reached
SHAPES = ("velocity_radps", "count_per_rad", "phase_rad", "rest_rad", "nominal_V", "gap_rad")
_GAP, _LIGHT_DRIVE = (5e-3, 0.5), 0.2  # of the range that was reached; of the inertia that a drive moves
_NOMINAL = (0.9, 1.6)  # of the supply's median: where a drive gives the commanded effort
_WHOLE_LOG = ("sensor.clock_skew", "joint.axis_tilt")


@dataclass(frozen=True)
class Ranges:
    """Typical magnitudes at one joint: torque, speed, position (low, high), inertia, bearing load, commanded effort."""

    torque: float
    speed: float
    low: float
    high: float
    inertia: float
    load: float
    effort: float


def ranges_of(model: MechanismModel, series: Sequence[Series], joint: int, effort: float) -> Ranges:
    """Magnitudes at a joint over all trials, from smoothed columns q, qd, qdd."""
    q, qd, qdd = (np.concatenate([s.columns[n] for s in series]) for n in ("q", "qd", "qdd"))
    thin = np.s_[:: max(1, len(q) // 4000)]
    torque, load = inverse_dynamics(model.tree, q[thin], qd[thin], qdd[thin], model.gravity_W)
    inertia = float(np.median(mass_matrix(model.tree, q[thin])[:, joint, joint]))
    return Ranges(
        torque=max(_size(torque[:, joint]), effort, 1e-9),
        speed=max(_size(qd[:, joint]), 1e-9),
        low=float(q[:, joint].min()),
        high=float(q[:, joint].max()),
        inertia=max(inertia, 1e-12),
        load=max(_size(load[:, joint]), 1e-9),
        effort=effort,
    )


def _size(values: FloatArray) -> float:
    return float(np.quantile(np.abs(values), _QUANTILE))


def candidates_of(model: MechanismModel, series: Sequence[Series]) -> tuple[Candidate, ...]:
    """Every effect of the library that these columns can reveal, at every joint, in library order."""
    out = []
    for each in EFFECTS:
        if "mechanism" not in each.kinds or not _observable(each, model, series):
            continue
        whole = each.name in _WHOLE_LOG
        for j, link in enumerate(model.tree[:1] if whole else model.tree):
            ranges = ranges_of(model, series, j, _effort(model, series, j))
            where = Place() if whole else Place(joint=link.name)
            null = _null(each, model, j, ranges, series)
            bounds = {p.name: _bounds(p.name, each, null, ranges) for p in each.parameters}
            if each.name == "joint.friction_asymmetry" and model.friction[j] > 0.0:
                bounds["torque_Nm"] = (-float(model.friction[j]), float(model.friction[j]))
            start = {n: float(np.clip(_start(n, each, null[n], ranges), *bounds[n])) for n in null}
            shapes = tuple(n for n in null if n in SHAPES)
            extra_starts = _probes(each, null, bounds, ranges)
            stops = {"lower_rad": ranges.low, "upper_rad": ranges.high}
            reached = {n: v for n, v in stops.items() if n in null}
            out.append(
                Candidate(
                    each, where, null, start, bounds, shapes=shapes, extra_starts=extra_starts, max_excursion=reached
                )
            )
    return tuple(out)


def nuisances_of(model: MechanismModel, row_s: float) -> tuple[Candidate, ...]:
    """Declared inertia, weight, friction, damping and effort of each joint within their tolerance.

    Inputs meet readings within a share of a row only: loops read before they write, and engines act on whole steps.
    """
    out = []
    if model.drive.type != "none":
        one, reach = {"delay_s": 0.0}, MEETING * row_s
        place = Place(joint=model.tree[0].name)
        out.append(Candidate(effect("actuator.delay"), place, one, one, {"delay_s": (-reach, reach)}, True))
    for j, link in enumerate(model.tree):
        inertia = float(mass_matrix(model.tree, np.zeros((1, len(model.tree))))[0, j, j])
        slack = {
            ("joint.armature", "inertia_kgm2"): (0.0, TOLERANCE * inertia),
            ("joint.gravity_load", "factor"): (1.0, TOLERANCE if link.mass_kg > 0.0 and not link.prismatic else 0.0),
            ("joint.coulomb_friction", "torque_Nm"): (float(model.friction[j]), TOLERANCE * float(model.friction[j])),
            ("joint.viscous_friction", "damping_Nms_per_rad"): (
                float(model.damping[j]),
                TOLERANCE * float(model.damping[j]),
            ),
            ("actuator.gain", "gain"): (1.0, TOLERANCE if model.drive.type != "none" else 0.0),
        }
        for (name, parameter), (value, half) in slack.items():
            if half > 0.0:
                one = {parameter: value}
                out.append(
                    Candidate(
                        effect(name), Place(joint=link.name), one, one, {parameter: (value - half, value + half)}, True
                    )
                )
    return tuple(out)


def _observable(each: Effect, model: MechanismModel, series: Sequence[Series]) -> bool:
    """Whether the log has what the effect acts on."""
    driven = model.drive.type != "none"
    if each.name == "actuator.supply_sag":
        return driven and all("aux:supply_V" in s.columns for s in series)
    if each.name in ("sensor.latency", "joint.backlash") or each.family == "actuator":
        return driven
    if each.name in ("joint.gravity_load", "joint.axis_tilt", "joint.load_dependent_friction"):
        return any(link.mass_kg > 0.0 and not link.prismatic for link in model.tree)
    # Rates come from the positions here, so that their age is known.
    return each.name != "sensor.velocity_age"


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


def _null(
    each: Effect, model: MechanismModel, joint: int, ranges: Ranges, series: Sequence[Series]
) -> dict[str, float]:
    null = each.null()
    declared = {
        "joint.coulomb_friction": ("torque_Nm", model.friction[joint]),
        "joint.viscous_friction": ("damping_Nms_per_rad", model.damping[joint]),
    }
    if each.name in declared:
        name, value = declared[each.name]
        null[name] = float(value)
    span = ranges.high - ranges.low
    if each.name == "joint.hard_stop":
        null["lower_rad"], null["upper_rad"] = ranges.low - span, ranges.high + span
    if each.name == "actuator.saturation":
        null["limit_Nm"] = 4.0 * max(ranges.effort, 1e-9)
    if each.name == "joint.spring":
        null["rest_rad"] = 0.5 * (ranges.low + ranges.high)
    if each.name == "actuator.supply_sag":
        null["nominal_V"] = float(np.median(np.concatenate([s.columns["aux:supply_V"] for s in series])))
    return null


def _bounds(name: str, each: Effect, null: dict[str, float], r: Ranges) -> tuple[float, float]:
    """Plausible values of a parameter at a joint with these magnitudes."""
    span = r.high - r.low
    signed = each.name in ("joint.friction_asymmetry", "actuator.bias")
    table = {
        "torque_Nm": (-r.torque if signed else 0.0, r.torque + null.get("torque_Nm", 0.0)),
        "damping_Nms_per_rad": (0.0, r.torque / r.speed + 2.0 * null.get("damping_Nms_per_rad", 0.0)),
        "drag_Nms2_per_rad2": (0.0, r.torque / r.speed**2),
        "velocity_radps": (r.speed / 300.0, r.speed),
        "radius_m": (0.0, r.torque / r.load),
        "stiffness_Nm_per_rad": (
            (r.torque / max(span, 1e-9), _hardest(r))
            if each.name == "joint.hard_stop"
            else (0.0, 4.0 * r.torque / max(span, 1e-9))
        ),
        "rest_rad": (r.low - span, r.high + span),
        "lower_rad": (r.low - span, 0.5 * (r.low + r.high)),
        "upper_rad": (0.5 * (r.low + r.high), r.high + span),
        "loss_s_per_rad": (0.0, _MOST_LOSS / r.speed),
        "inertia_kgm2": (-0.8 * r.inertia, 4.0 * r.inertia),
        "limit_Nm": (0.1 * max(r.effort, 1e-9), 4.0 * max(r.effort, 1e-9)),
        "band_Nm": (0.0, max(r.effort, 1e-9)),
        "count_per_rad": (_REPEATED * np.pi / max(span, 1e-6), 300.0 / max(span, 1e-6)),
        "gap_rad": (_GAP[0] * span, _GAP[1] * span),
        "gap_inertia_kgm2rad": (0.0, _LIGHT_DRIVE * _GAP[1] * span * r.inertia),
        "offset_rad": (-0.3 * span, 0.3 * span),
    }
    parameter = next(p for p in each.parameters if p.name == name)
    low, high = table.get(name, (parameter.low, parameter.high))
    if name == "nominal_V":
        low, high = _NOMINAL[0] * null[name], _NOMINAL[1] * null[name]  # A supply may sag all the time.
    return max(low, parameter.low), max(min(high, parameter.high), max(low, parameter.low) + 1e-12)


def _hardest(r: Ranges) -> float:
    """The stiffest end of travel: ten thousand times what the torque does over the range, or what steps can follow."""
    soft = r.torque / max(r.high - r.low, 1e-9)
    return max(10.0 * soft, min(1e4 * soft, _STIFFEST * r.inertia / _STEP_S**2))


def _probes(
    each: Effect, null: dict[str, float], bounds: dict[str, tuple[float, float]], r: Ranges
) -> tuple[dict[str, float], ...]:
    """Values to try of effects that have a threshold."""
    if each.name == "joint.hard_stop":
        return _stops(null, bounds, r)
    if each.name == "actuator.saturation":
        return tuple({"limit_Nm": share * r.effort} for share in (0.2, 0.35, 0.5, 0.65, 0.8, 0.95, 1.1) if r.effort)
    if each.name == "joint.backlash":
        return tuple(
            {"gap_rad": share * bounds["gap_rad"][1], "gap_inertia_kgm2rad": part * bounds["gap_inertia_kgm2rad"][1]}
            for share in (0.05, 0.3)
            for part in (0.0005, 0.002, 0.008, 0.03, 0.12, 0.4)
        )
    return ()


def _stops(null: dict[str, float], bounds: dict[str, tuple[float, float]], r: Ranges) -> tuple[dict[str, float], ...]:
    """Ends of travel within the range that was reached, near its edges first, soft to hard, above, below and both."""
    span = r.high - r.low
    soft, hard = bounds["stiffness_Nm_per_rad"]
    return tuple(
        {
            "lower_rad": r.low + share * span if "lower" in sides else null["lower_rad"],
            "upper_rad": r.high - share * span if "upper" in sides else null["upper_rad"],
            "stiffness_Nm_per_rad": float(stiffness),
            "loss_s_per_rad": 0.1 * bounds["loss_s_per_rad"][1],
        }
        for sides in (("upper",), ("lower",), ("lower", "upper"))
        for share in _STOP_SHARES
        for stiffness in np.geomspace(3.0 * soft, 0.3 * hard, 3)
    )


def _start(name: str, each: Effect, null: float, r: Ranges) -> float:
    """Shape parameters begin in the middle of what is plausible, strengths at no effect."""
    span = r.high - r.low
    return {
        "velocity_radps": 0.1 * r.speed,
        "count_per_rad": 12.0 / max(span, 1e-6),
        "gap_rad": 0.1 * span,
    }.get(name, null)
