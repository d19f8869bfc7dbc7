"""Times at which inputs act and readings are taken: the stamps, or an even clock that stamps follow with jitter.

A control loop that wakes late reads and sends late. A logger that stamps what it receives is late by itself: neither
readings nor inputs are. Which of the two made a recording is not written in it, but a model that explains it shows it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from schemas.arrays import FloatArray
from simgap.recording.recording import Trial

InputTiming = Literal["stamps", "even_inputs", "even"]
TIMINGS: tuple[InputTiming, ...] = ("stamps", "even_inputs", "even")
_UNEVEN = 0.3  # of a row: stamps further from an even beat do not follow one
_EVEN_STAMPS = 1e-4  # of a row: stamps that even need no other beat
_LONGEST = 5  # rows of a gap over which inputs are drawn on


def possible_timings(trial: Trial) -> tuple[InputTiming, ...]:
    """The timings that a trial's stamps allow: "stamps" alone where they are even, or follow no even clock."""
    even = even_stamps(trial.t_s)
    if even is None or not (np.diff(trial.t_s) > 0.0).all():
        return TIMINGS[:1]
    off = float(np.abs(trial.t_s - even).max() / np.median(np.diff(trial.t_s)))
    if not _EVEN_STAMPS < off < _UNEVEN:
        return TIMINGS[:1]
    driven = trial.has("effort") or trial.has("command")
    return TIMINGS if driven else ("stamps", "even")


def stamp_jitter_s(trial: Trial) -> float | None:
    """Root mean square deviation of the stamps from the nearest even clock; None for fewer than three."""
    even = even_stamps(trial.t_s)
    return None if even is None else float(np.sqrt(np.mean((trial.t_s - even) ** 2)))


def even_stamps(t_s: FloatArray) -> FloatArray | None:
    """(n,) ticks of the even clock nearest to stamps (n,), lost rows left out; None for fewer than three."""
    if len(t_s) < 3:
        return None
    numbers = _numbers(t_s)
    return np.asarray(np.polyval(np.polyfit(numbers, t_s, 1), numbers), dtype=np.float64)


def with_timing(trial: Trial, timing: InputTiming) -> Trial:
    """The trial with the stamps at which it was read, and inputs as means of what acted from each up to the next.

    Inputs are held from tick to tick. Those of lost rows went from one value to the next at an unknown time: a straight
    line is right on average, for ramps as for steps. The first tick of an even clock need not be 0.
    """
    even = even_stamps(trial.t_s) if timing != "stamps" else None
    sent_at = trial.t_s if even is None else even
    read_at = sent_at if timing == "even" else trial.t_s
    given = {n: np.nan_to_num(getattr(trial, n)) for n in ("effort", "command") if trial.has(n)}
    return replace(trial, t_s=read_at, **{n: _acted(v, sent_at, read_at) for n, v in given.items()})


def _acted(values: FloatArray, sent_at: FloatArray, read_at: FloatArray) -> FloatArray:
    """(n, j) means over the rows that begin at `read_at` of values (n, j) held from `sent_at`."""
    numbers = _numbers(sent_at)
    if len(numbers) < 2 or (sent_at is read_at and numbers[-1] == len(numbers) - 1):
        return values
    lost = np.diff(numbers) - 1
    between = [np.arange(a + 1, b) for a, b, k in zip(numbers[:-1], numbers[1:], lost, strict=True) if 0 < k < _LONGEST]
    every = np.sort(np.concatenate([numbers, *between]))
    times = np.interp(every, numbers, sent_at)
    held = np.stack([np.interp(every, numbers, column) for column in values.T], axis=1)
    total = np.concatenate([np.zeros((1, held.shape[1])), np.cumsum(held[:-1] * np.diff(times)[:, None], axis=0)])
    # Before the first and after the last beat the nearest value holds.
    times = np.concatenate([[times[0] - 1.0], times, [times[-1] + 1.0]])
    total = np.concatenate([total[:1] - held[:1], total, total[-1:] + held[-1:]])
    until = np.stack([np.interp(read_at, times, column) for column in total.T], axis=1)
    means = np.diff(until, axis=0) / np.diff(read_at)[:, None]
    return np.concatenate([means, values[-1:]])


def _numbers(t_s: FloatArray) -> FloatArray:
    """(n,) which row of an unbroken log each stamp belongs to."""
    steps = np.diff(t_s)
    if not len(steps) or not (steps > 0.0).all():
        return np.arange(len(t_s), dtype=float)
    steps = steps / np.median(steps)
    rows = np.maximum(np.round(steps), 1.0)
    # One late stamp lengthens a step and shortens the next: no row was lost there.
    late = rows[:-1] + rows[1:] - np.maximum(np.round(steps[:-1] + steps[1:]), 2.0)
    rows[:-1] -= np.clip(late, 0.0, rows[:-1] - 1.0)
    return np.concatenate([[0.0], np.cumsum(rows)])
