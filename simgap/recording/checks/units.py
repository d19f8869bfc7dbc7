"""Checks of length and angle units: a velocity and the slope of its position must agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, Location, finding
from simgap.recording.checks.check import Checked, Setting, mapped
from simgap.recording.checks.flight import flight_acceleration
from simgap.recording.checks.rates import Slopes, fast_rows, linear_slopes, ratio, turning_slopes
from simgap.recording.checks.stack import stacked
from simgap.recording.recording import Trial

_CLOSE = 0.1
_RAD_PER_DEGREE = np.pi / 180.0
_CLOCKS = {1e3: "ms", 1e6: "us", 1e9: "ns"}
_SLOW_CLOCK_S = 0.5  # Nobody films a toss or a hinge with fewer frames than this apart.
_MOST_SPAN_M = 30.0


@dataclass(frozen=True)
class Rate:
    """A recorded velocity per implied one: `column` names both, `turns` for angles."""

    column: str
    position: str
    ratio: float
    turns: bool


def check_units(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Milliseconds, millimetres and degrees become SI where the data prove them; the rest is reported.

    Proof is one factor (1000, pi/180 ...) within 10 % between recorded and implied velocities, or between the fall of
    a tossed body and the declared gravity. `rate_hz` is checked before.
    """
    if not trials:
        return Checked(trials)
    trials, findings = _clock(setting, trials)
    trials, more = _lengths(setting, trials)
    findings += more
    for rate in _rates(setting, trials):
        trials, more = _judge(setting, trials, rate)
        findings += more
    return Checked(trials, findings)


def _rates(setting: Setting, trials: Sequence[Trial]) -> list[Rate]:
    rates: list[Rate] = []
    declared = setting.spec.columns
    if "v" in declared and "p" in declared:
        rates.append(_rate("v", "p", linear_slopes(trials, lambda t: t.p), stacked(trials, lambda t: t.v_W), False))
    if {"w_body", "w_world"} & set(declared):
        turning = turning_slopes(trials, lambda t: t.quat_wxyz)
        rates.append(_rate("w", "orientation", turning, stacked(trials, lambda t: t.w_B), True))
    for k, joint in enumerate(setting.joints):
        if f"qd_{joint.name}" in declared:
            slopes = linear_slopes(trials, lambda t, k=k: t.q[:, [k]])
            recorded = stacked(trials, lambda t, k=k: t.qd[:, [k]])
            rates.append(_rate(f"qd_{joint.name}", f"q_{joint.name}", slopes, recorded, joint.turns))
    return rates


def _rate(column: str, position: str, slopes: Slopes, recorded: FloatArray, turns: bool) -> Rate:
    rows = fast_rows(slopes.central, recorded)
    return Rate(column, position, ratio(recorded, slopes.central, rows), turns)


def _is(value: float, factor: float) -> bool:
    return abs(value / factor - 1.0) < _CLOSE


def _clock(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Stamps in ms, us or ns without a `rate_hz`: every angular velocity is too large by that factor."""
    step = float(np.median([np.median(np.diff(t.t_s)) for t in trials]))
    if setting.spec.rate_hz is not None or step < _SLOW_CLOCK_S:
        return Checked(trials)
    turning = [rate.ratio for rate in _rates(setting, trials) if rate.turns]
    fall = float(np.linalg.norm(flight_acceleration(trials))) / _gravity(setting)
    proofs = [f for f in _CLOCKS if any(_is(r, f) for r in turning) or _is(fall, f**-2)]
    if not proofs:
        text = f"rows are {step:.4g} s apart; if the stamps are no seconds, convert them"
        return Checked(trials, (_found("gap/time-unit", text, step, _SLOW_CLOCK_S, "s"),))
    factor = proofs[0]
    text = f"stamps are in {_CLOCKS[factor]}: velocities and fall agree only then; divided by {factor:g}"
    changed = mapped(trials, lambda t: replace(t, t_s=t.t_s / factor, t0_s=t.t0_s / factor))
    return Checked(changed, (_found("gap/time-unit", text, step, None, "s"),))


def _lengths(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Positions and velocities in mm when a tossed body falls 1000 times too fast."""
    if "p" not in setting.spec.columns:
        return Checked(trials)
    fall = float(np.linalg.norm(flight_acceleration(trials)))
    if _gravity(setting) > 0.0 and _is(fall, 1e3 * _gravity(setting)):
        recorded = next((r.ratio for r in _rates(setting, trials) if r.column == "v"), 1.0)
        both = _is(recorded, 1.0)
        text = f"the body falls at {fall:.0f} per s2: positions{' and velocities' * both} are in mm; divided by 1000"
        changed = mapped(trials, lambda t: replace(t, p=t.p / 1e3, v_W=t.v_W / 1e3 if both else t.v_W))
        return Checked(changed, (_found("gap/millimetres", text, fall, _gravity(setting), "m/s2"),))
    span = max(float(np.ptp(t.p, axis=0).max()) for t in trials)
    if span > _MOST_SPAN_M:
        text = f"the body travels {span:.4g} m; if that is mm, convert it"
        return Checked(trials, (_found("gap/millimetres-suspected", text, span, _MOST_SPAN_M, "m"),))
    return Checked(trials)


def _judge(setting: Setting, trials: tuple[Trial, ...], rate: Rate) -> Checked:
    """One factor between a velocity and its position names the unit of one of them."""
    small, code, unit = (_RAD_PER_DEGREE, "gap/degrees", "degrees") if rate.turns else (1e-3, "gap/millimetres", "mm")
    size = abs(rate.ratio)
    if rate.ratio > 0.0 and _is(size, small):
        text = f"'{rate.position}' is in {unit}: its slope is {1 / size:.4g} times '{rate.column}'; converted"
        return Checked(_scale(setting, trials, rate.position, small), (_found(code, text, 1 / size, 1.0),))
    if rate.ratio > 0.0 and _is(size, 1.0 / small):
        text = f"'{rate.column}' is in {unit}: it is {size:.4g} times the slope of '{rate.position}'; converted"
        return Checked(_scale(setting, trials, rate.column, small), (_found(code, text, size, 1.0),))
    if not 1.0 / 1.25 < rate.ratio < 1.25:
        text = f"'{rate.column}' is {rate.ratio:.3g} times the slope of '{rate.position}'"
        return Checked(trials, (_found("gap/velocity-inconsistent", text, rate.ratio, 1.0),))
    return Checked(trials)


def _scale(setting: Setting, trials: tuple[Trial, ...], column: str, factor: float) -> tuple[Trial, ...]:
    if column in ("p", "v", "w"):
        field = {"p": "p", "v": "v_W", "w": "w_B"}[column]
        return mapped(trials, lambda t: replace(t, **{field: getattr(t, field) * factor}))
    field, joint = column.split("_", 1)
    per_joint = np.array([factor if info.name == joint else 1.0 for info in setting.joints])
    fields = ("q", "command") if field == "q" else (field,)  # A position is commanded in its own unit.
    return mapped(trials, lambda t: replace(t, **{name: getattr(t, name) * per_joint for name in fields}))


def _gravity(setting: Setting) -> float:
    return float(np.linalg.norm(setting.spec.world.gravity_mps2))


def _found(code: str, text: str, value: float, bound: float | None, unit: str = "") -> Diagnostic:
    return finding(code, text, where=Location(file="measurement.yaml"), value=value, bound=bound, unit=unit)
