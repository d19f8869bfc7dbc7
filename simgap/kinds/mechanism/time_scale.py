"""The time scales of a mechanism's recording, from its readings: what is short or long is so beside these.

From readings at their stamps to two times. A radian of the motion is the spread of positions over that of rates, for
the joint for which it is least. Local cubics span a quarter of it, or of the spread of rates over that of
accelerations where that is less: joints that stand and then jump move slowly on average, but not when they move. What
drifts through its trials has no time of its own: a radian is at most a twelfth of a trial, a span a quarter of that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

from schemas.arrays import FloatArray
from simgap.recording.recording import Trial

CUBIC_ORDER = 3
LEAST_CUBIC_ROWS = 7  # of a local cubic with four free numbers: the rest shows the noise
_SPAN_RADIANS = 0.25  # a cubic through a sine strays by 2e-5 of its amplitude over this
_RADIANS_PER_TRIAL = 12.0  # at least: a swing of two periods has so many
_CUBICS_PER_TRIAL = _RADIANS_PER_TRIAL / _SPAN_RADIANS
_LADDER = 1.25  # between one span that is tried and the next
_SCALE_ROUNDS, _SETTLED = 8, 0.01  # of the span that its own accelerations ask for; three rounds are usual
_MOVES = 3.0  # noise levels; a joint that moves by less has no time scale
_STEPS_PER_SPAN = 12.0  # of roll-outs, and of rows where logs are thinned: 0.02 radians each
_FINEST_STEPS = 40.0  # per span: what a controller does faster dies out within few rows

_Even = tuple[float, FloatArray, FloatArray]


@dataclass(frozen=True)
class TimeScale:
    """`radian_s` of the motion, which is the horizon of short roll-outs, and `span_s` that a local cubic follows."""

    radian_s: float
    span_s: float

    @property
    def largest_step_s(self) -> float:
        """Longest step of roll-outs; rows closer than this are thinned."""
        return self.span_s / _STEPS_PER_SPAN

    @property
    def finest_step_s(self) -> float:
        """Shortest step that a fast controller may ask for."""
        return self.span_s / _FINEST_STEPS


def time_scale(trials: Sequence[Trial]) -> TimeScale:
    """The scale that trials of one mechanism share. Raises ValueError where all have fewer rows than a cubic needs."""
    evened = [even_readings(t.t_s, t.q) for t in trials if len(t) >= LEAST_CUBIC_ROWS]
    if not evened:
        raise ValueError(f"{max(map(len, trials))} rows are too few for derivatives; {LEAST_CUBIC_ROWS} are needed")
    enough = 0.5 * np.median([len(q) for _, _, q in evened])
    evened = [one for one in evened if len(one[2]) >= enough]
    row_s = min(step for step, _, _ in evened)
    trial_s = float(np.median([times[-1] - times[0] for _, times, _ in evened]))
    span_s = max(min(_least_cross_validation(evened), trial_s / _CUBICS_PER_TRIAL), LEAST_CUBIC_ROWS * row_s)
    radian_s = span_s / _SPAN_RADIANS
    for _ in range(_SCALE_ROUNDS):
        radians = _radians(evened, span_s)
        if radians is None:
            break
        radian_s, before = radians[0], span_s
        span_s = min(_SPAN_RADIANS * min(radians), trial_s / _CUBICS_PER_TRIAL)
        span_s = max(span_s, row_s)  # Where readings jump there is no other limit.
        if abs(span_s - before) < _SETTLED * before:
            break
    return TimeScale(max(min(radian_s, trial_s / _RADIANS_PER_TRIAL), span_s / _SPAN_RADIANS), span_s)


def even_readings(t_s: FloatArray, q: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Median step, even stamps (m,) and readings (m, j) there, from readings (n, j) at stamps (n,)."""
    step_s = float(np.median(np.diff(t_s)))
    even_s = np.arange(t_s[0], t_s[-1] + 0.5 * step_s, step_s)
    return step_s, even_s, np.stack([np.interp(even_s, t_s, column) for column in q.T], axis=1)


def odd_rows(span_s: float, step_s: float, count: int) -> int:
    """Rows of a local cubic over a span: odd, no fewer than it needs, no more than there are."""
    rows = max(round(span_s / step_s), LEAST_CUBIC_ROWS) | 1
    return min(rows, count if count % 2 else count - 1)


def _least_cross_validation(evened: Sequence[_Even]) -> float:
    """Span (s) whose cubics predict best the readings that they do not see; all joints weigh alike.

    Generalised cross-validation (Craven and Wahba, Numer. Math. 31, 1979): nothing that shows above the noise is
    smoothed away.
    """
    step_s = float(np.median([step for step, _, _ in evened]))
    longest_s = 0.5 * min(step * len(q) for step, _, q in evened)
    spans, errors = [LEAST_CUBIC_ROWS * step_s], []
    while spans[-1] * _LADDER <= longest_s:
        spans.append(spans[-1] * _LADDER)
    for span_s in spans:
        squares, count = np.zeros(evened[0][2].shape[1]), 0
        for step, _, q in evened:
            rows = odd_rows(span_s, step, len(q))
            left = (q - _filtered(q, rows, 0, step)) / (1.0 - _centre(rows))
            inner = left[rows // 2 : len(q) - rows // 2]
            squares, count = squares + (inner**2).sum(axis=0), count + len(inner)
        errors.append(squares / count)
    tried = np.array(errors)
    read = (tried > 0.0).all(axis=0)  # A joint that is never seen to move fits any span.
    return spans[int(np.argmin(np.log(tried[:, read]).sum(axis=1)))] if read.any() else spans[0]


def _radians(evened: Sequence[_Even], span_s: float) -> tuple[float, float] | None:
    """Spread of positions over that of rates, and of rates over that of accelerations, both s, without the noise.

    Each of the joint for which it is least; None where none moves. Derivatives are those of cubics over `span_s`.
    """
    noise, squares = np.zeros(evened[0][2].shape[1]), np.zeros((3, evened[0][2].shape[1]))
    for step, _, q in evened:
        rows = odd_rows(span_s, step, len(q))
        left = q - _filtered(q, rows, 0, step)
        variance = (1.4826 * np.median(np.abs(left), axis=0)) ** 2 / max(1.0 - _centre(rows), 0.1)
        noise += len(q) * variance
        squares[0] += len(q) * (q.var(axis=0) - variance)
        for order in (1, 2):
            gain = np.sum(np.asarray(savgol_coeffs(rows, CUBIC_ORDER, deriv=order, delta=step)) ** 2)
            square = (_filtered(q, rows, order, step) ** 2).mean(axis=0)
            squares[order] += len(q) * (square - gain * variance)
    moves = (squares[0] > _MOVES**2 * noise) & (squares > 0.0).all(axis=0)
    if not moves.any():
        return None
    position, rate = np.sqrt(squares[:2, moves] / squares[1:, moves]).min(axis=1).tolist()
    return position, rate


def _filtered(q: FloatArray, rows: int, order: int, step_s: float) -> FloatArray:
    return np.asarray(savgol_filter(q, rows, CUBIC_ORDER, deriv=order, delta=step_s, axis=0))


def _centre(rows: int) -> float:
    """Weight of a reading in its own smoothed value."""
    return float(np.asarray(savgol_coeffs(rows, CUBIC_ORDER))[rows // 2])
