"""Checks of stamps: order, unit (s), gaps, jitter and rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from schemas.arrays import FloatArray
from schemas.diagnostics import Severity
from simgap.recording.checks.check import Checked, Hit, Setting, mapped, over_trials
from simgap.recording.checks.finite import MIN_ROWS
from simgap.recording.recording import Trial

SAME_RATE = 0.005
JITTER = 0.02  # of a period
_PLAUSIBLE_STEP = 0.3  # of the median step: closer stamps are two clocks interleaved
_LATE = 3.0  # periods
_UNITS = {1e3: "ms", 1e6: "us", 1e9: "ns"}
_SMOOTHER = 0.6
_NEARBY = 15  # steps


def order_stamps(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Rows sorted by stamp, one per stamp, `t_s` from 0.

    Stamps that run back by less than _LATE periods in no sortable way are late ones: the rows keep their order, on the
    regular clock through them. A trial whose clock restarts is left out.
    """
    ordered: list[Trial] = []
    repaired: list[Hit] = []
    late: list[Hit] = []
    broken: list[Hit] = []
    for trial in trials:
        steps = np.diff(trial.t_s)
        if (steps > 0.0).all():
            ordered.append(_from_zero(trial))
            continue
        backward, doubled = int((steps < 0.0).sum()), int((steps == 0.0).sum())
        t_s, order = np.unique(trial.t_s, return_index=True)  # The first row of each stamp, sorted.
        sorted_steps = np.diff(t_s)
        if len(t_s) < MIN_ROWS:
            broken.append(Hit(trial, doubled, f"{len(trial)} rows have {len(t_s)} different stamps"))
            continue
        if backward and sorted_steps.min() < _PLAUSIBLE_STEP * np.median(sorted_steps):
            text = f"the clock goes back {backward} times, by up to {-steps.min():.3g} s"
            period = float(np.ptp(t_s)) / (len(trial) - 1)
            if -steps.min() < _LATE * period:
                late.append(Hit(trial, backward, text))
                ordered.append(replace(trial, t_s=period * np.arange(len(trial)), t0_s=float(t_s[0])))
            else:
                broken.append(Hit(trial, backward, text))
            continue
        repaired.append(Hit(trial, backward + doubled, f"{backward} rows out of order, {doubled} stamped twice"))
        ordered.append(_from_zero(trial.rows(order)))
    findings = over_trials("gap/time-not-increasing", "rows sorted by stamp", repaired, len(trials), unit="rows")
    text = "stamps run back; the rows are put on a regular clock"
    findings += over_trials("gap/stamp-jitter", text, late, len(trials), unit="rows")
    findings += over_trials(
        "gap/clock-restarts",
        "no one clock through these trials, left out",
        broken,
        len(trials),
        unit="rows",
        severity=Severity.WARNING if ordered else Severity.ERROR,
    )
    return Checked(tuple(ordered), findings)


def check_rate(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Stamps in ms, us or ns become seconds when `rate_hz` proves it; other differences from `rate_hz` are reported."""
    declared = setting.spec.rate_hz
    if declared is None or "t" not in setting.spec.columns or not trials:
        return Checked(trials)
    rates = np.array([1.0 / period_s(trial.t_s) for trial in trials])
    ratio = declared / float(np.median(rates))
    factor = next((f for f in _UNITS if abs(ratio / f - 1.0) < 0.1), None)
    if factor is not None:
        text = f"stamps are in {_UNITS[factor]} for the declared {declared:g} Hz; divided by {factor:g}"
        hits = [Hit(t, r, f"{r:.4g} rows per unit of t") for t, r in zip(trials, rates, strict=True)]
        changed = mapped(trials, lambda t: replace(t, t_s=t.t_s / factor, t0_s=t.t0_s / factor))
        return Checked(changed, over_trials("gap/time-unit", text, hits, len(trials), bound=declared, unit="Hz"))
    hits = [
        Hit(trial, rate, f"{rate:.5g} Hz")
        for trial, rate in zip(trials, rates, strict=True)
        if abs(rate / declared - 1.0) > SAME_RATE
    ]
    text = f"stamps do not tick at {declared:g} Hz; the stamps are kept"
    return Checked(trials, over_trials("gap/rate-mismatch", text, hits, len(trials), bound=declared, unit="Hz"))


def find_gaps(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Reports missing frames: steps that are longer than the clock's own spread explains."""
    hits: list[Hit] = []
    for trial in trials:
        steps = np.diff(trial.t_s)
        period = median_filter(steps, _NEARBY, mode="nearest")  # A logger may change its pace; that is no gap.
        spread = 1.4826 * float(np.median(np.abs(steps / period - 1.0)))
        missing = np.where(steps > (1.6 + 6.0 * spread) * period, np.rint(steps / period) - 1.0, 0.0)
        if missing.sum():
            text = f"{int(missing.sum())} frames missing, the longest gap is {steps.max():.3g} s at {_at(trial, steps)}"
            hits.append(Hit(trial, float(missing.sum()), text))
    return Checked(trials, over_trials("gap/dropped-frames", "frames are missing", hits, len(trials), unit="frames"))


def settle_jitter(setting: Setting, trials: tuple[Trial, ...]) -> Checked:
    """Jittering stamps are replaced by the regular clock through them when the motion is smoother on that clock.

    Both clocks must predict each row from its four neighbours (cubic); the median error over moving rows decides.
    """
    if "t" not in setting.spec.columns:
        return Checked(trials)
    jitter = {trial.id: _jitter(trial) for trial in trials}
    shaky = [trial for trial in trials if JITTER < jitter[trial.id] < 0.5 and len(trial) >= 30]
    if not shaky:
        return Checked(trials)
    stamps, regular = (
        np.concatenate([_prediction_errors(_motion(t), clock(t)) for t in shaky])
        for clock in (lambda t: t.t_s, _regular_clock)
    )
    moving = stamps + regular > 0.0
    ratio = float(np.median(regular[moving]) / np.median(stamps[moving])) if moving.any() else 1.0
    hits = [Hit(t, jitter[t.id], f"{100 * jitter[t.id]:.1f} % of a period") for t in shaky]
    if ratio < _SMOOTHER:
        text = f"stamps jitter; on a regular clock the motion is {1 / ratio:.1f} times smoother, so that clock is used"
        settled = mapped(trials, lambda t: replace(t, t_s=_regular_clock(t)) if JITTER < jitter[t.id] < 0.5 else t)
        return Checked(settled, over_trials("gap/stamp-jitter", text, hits, len(trials), bound=JITTER))
    text = "sampling is irregular; the stamps are kept"
    return Checked(
        trials, over_trials("gap/stamp-jitter", text, hits, len(trials), bound=JITTER, severity=Severity.INFO)
    )


def period_s(t_s: FloatArray) -> float:
    """The clock's period: the slope of the stamps over their counted ticks, so that gaps and jitter do not bias it."""
    ticks = _ticks(t_s)
    return float((t_s[-1] - t_s[0]) / max(ticks[-1], 1.0))


def _ticks(t_s: FloatArray) -> FloatArray:
    steps = np.diff(t_s)
    return np.concatenate([[0.0], np.cumsum(np.maximum(np.rint(steps / np.median(steps)), 1.0))])


def _from_zero(trial: Trial) -> Trial:
    first = float(trial.t_s[0])
    return replace(trial, t_s=trial.t_s - first, t0_s=first)


def _at(trial: Trial, steps: FloatArray) -> str:
    return f"t = {trial.t_s[int(np.argmax(steps))]:.3f} s"


def _regular_clock(trial: Trial) -> FloatArray:
    ticks = _ticks(trial.t_s)
    slope, offset = np.polyfit(ticks, trial.t_s, 1)
    regular = offset + slope * ticks
    return regular - regular[0]


def _jitter(trial: Trial) -> float:
    return float(np.std(trial.t_s - trial.t_s[0] - _regular_clock(trial)) / period_s(trial.t_s))


def _motion(trial: Trial) -> FloatArray:
    """(n, k) positions that move smoothly."""
    both = np.column_stack([trial.p, trial.q])
    return both[:, np.isfinite(both).all(axis=0)]


def _prediction_errors(x: FloatArray, t_s: FloatArray) -> FloatArray:
    """Distance (n - 4,) of each row from the cubic through the two rows before and the two after it."""
    near, rows = ([a[k : len(a) - 4 + k] for k in (0, 1, 3, 4)] for a in (t_s, x))
    middle = t_s[2:-2]
    predicted = np.zeros_like(rows[0])
    for i in range(4):
        others = [k for k in range(4) if k != i]
        weight = np.prod([(middle - near[k]) / (near[i] - near[k]) for k in others], axis=0)
        predicted += weight[:, None] * rows[i]
    return np.linalg.norm(predicted - x[2:-2], axis=1)
