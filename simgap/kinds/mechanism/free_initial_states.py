"""Roll-outs with free initial states: residuals with the first-order effect of each window's start projected out.

Initial states come from noisy positions, the rates with the most noise: within a second its effect exceeds that of
most causes. Each window's initial state is free within that noise (output error with free initial conditions: Ljung,
System Identification, 1999, section 7.4), to first order, so that no further roll-out is needed (Golub and Pereyra,
SIAM J. Numer. Anal. 10, 1973). The error of the step length is removed likewise, once for all candidates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from sim.dynamics.mechanism import Windows, rollout, windows_from_starts
from simgap.kinds.mechanism.apply_model import Applied
from simgap.kinds.mechanism.smooth import Smooth
from simgap.kinds.mechanism.windows import Cut, windows_of

_SEARCHED = 3  # steps towards where a window began
_EXPLAINED = 3.0  # noise levels that a window's residual may have if its start is to be estimated
_HELD = 0.01  # precision with which a start is held, of its noise's: smoothing rounds it besides
# Of motions with the step, half of it and a quarter: errors of first and second order in the step cancel (Richardson).
_TO_NO_STEP = (1.0 / 3.0, -2.0, 8.0 / 3.0)


@dataclass(frozen=True)
class FreeInitialStates:
    """Linear estimates of the initial states of windows (w) from their errors (w, c, j), which are flattened to c * j.

    start_sensitivity  (w, c * j, s) change of the errors per standard deviation of each of s initial values
    start_gain         (w, s, c * j) least-squares estimate of the initial values from errors, in standard deviations
    step_error         (w, c, j) change of the compared positions in the limit of small steps
    noise              (w, j) of what is compared
    q0, qd0            (w, j) offsets of the linearisation point from the readings
    """

    start_sensitivity: FloatArray
    start_gain: FloatArray
    step_error: FloatArray
    noise: FloatArray
    q0: FloatArray
    qd0: FloatArray

    def without(self, errors: FloatArray) -> FloatArray:
        """(w, c, j) errors with the step error added and the best initial states projected out."""
        flat = (errors + self.step_error).reshape(len(errors), -1, 1)
        return (flat - self.start_sensitivity @ (self.start_gain @ flat)).reshape(errors.shape)

    def with_sensor_state(self, fading: FloatArray) -> FreeInitialStates:
        """With the start of each joint's sensor free as well; `fading` (w, c, j): what a deviation of it changes."""
        windows, compared, joints = fading.shape
        by_joint = fading[..., None] * np.eye(joints)
        known = self.start_sensitivity.reshape(windows, compared, joints, -1)
        both = linearised_initial_states(np.concatenate([known, by_joint], axis=3), self.noise, self.step_error)
        return replace(both, q0=self.q0, qd0=self.qd0)


def linearised_initial_states(changes: FloatArray, noise: FloatArray, step_error: FloatArray) -> FreeInitialStates:
    """From `changes` (w, c, j, s) of compared positions per deviation of each initial value, and their noise (w, j)."""
    windows, compared, joints, numbers = changes.shape
    start_sensitivity = changes.reshape(windows, compared * joints, numbers)
    weighted = np.swapaxes(start_sensitivity, 1, 2) / np.tile(noise**2, compared)[:, None]
    start_gain = np.linalg.solve(weighted @ start_sensitivity + _HELD * np.eye(numbers), weighted)
    start_gain = start_gain.astype(np.float64, copy=False)
    return FreeInitialStates(start_sensitivity, start_gain, step_error, noise, *np.zeros((2, windows, joints)))


def initial_states_of(
    declared: Applied,
    model: Applied,
    logs: Sequence[Series],
    cuts: Sequence[Cut],
    smooth: Sequence[Smooth],
    step_s: float,
) -> list[FreeInitialStates]:
    """Per trial, the initial states of its windows, linearised under `model`.

    Windows that `model` or the declared model explains are linearised at their estimated initial state, because the
    first order does not hold across an impact. Elsewhere the estimate would only hide the model's error.
    """
    first, last = (_InitialStates.of(applied, logs, cuts, smooth, step_s) for applied in (declared, model))
    start_offsets = np.zeros((*first.noise_q.shape, 2))
    start_offsets = _estimated_offsets(first, start_offsets, np.zeros_like(first.read))
    start_offsets = _estimated_offsets(last, start_offsets, last.step_error(start_offsets))
    _, free = last.linearised_at(start_offsets)
    q0, qd0 = start_offsets[..., 0] * last.noise_q, start_offsets[..., 1] * last.noise_qd
    whole = replace(free, step_error=last.step_error(start_offsets), q0=q0, qd0=qd0)
    ends = np.cumsum([len(c.rows) for c in cuts])[:-1]
    parts = [np.split(getattr(whole, f.name), ends) for f in fields(FreeInitialStates)]
    return [FreeInitialStates(*part) for part in zip(*parts, strict=True)]


@dataclass(frozen=True)
class _InitialStates:
    """Windows (w) of all trials under one model, with noise of starts (w, j) and of what is compared (w, j).

    read, first_read   (w, c, j) and (w, j): readings that are compared, and those at the first rows.
    """

    applied: Applied
    windows: Windows
    cuts: Sequence[Cut]
    read: FloatArray
    first_read: FloatArray
    noise_q: FloatArray
    noise_qd: FloatArray
    noise: FloatArray
    step_s: float

    @staticmethod
    def of(
        applied: Applied, logs: Sequence[Series], cuts: Sequence[Cut], smooth: Sequence[Smooth], step_s: float
    ) -> _InitialStates:
        pieces = [(applied.recovered(log), piece) for log, piece in zip(logs, cuts, strict=True)]
        compared = [(applied.without_memory(log), piece) for log, piece in zip(logs, cuts, strict=True)]
        read = [piece.of(series.columns[piece.column][piece.rows]) for series, piece in compared]
        rows = [len(piece.rows) for piece in cuts]

        def by_window(each: Sequence[FloatArray]) -> FloatArray:
            return np.repeat(each, rows, axis=0)

        return _InitialStates(
            applied,
            windows_of(pieces, applied),
            cuts,
            np.concatenate(read),
            np.concatenate([series.columns["q"][piece.rows[:, 0]] for series, piece in compared]),
            noise_q=by_window([s.noise_gain * s.q_noise for s in smooth]),
            noise_qd=by_window([s.qd_noise for s in smooth]),
            noise=by_window([mean_noise(s, piece) for s, piece in zip(smooth, cuts, strict=True)]),
            step_s=step_s,
        )

    def rolled(self, start_offsets: FloatArray, finer: int = 1) -> tuple[FloatArray, FloatArray]:
        """Positions and rates (m, w, k, j) of roll-outs that begin so many deviations (m, w, j, 2) off the readings."""
        q0 = self.windows.q0 + start_offsets[..., 0] * self.noise_q
        qd0 = self.windows.qd0 + start_offsets[..., 1] * self.noise_qd
        start, model = windows_from_starts(self.windows, q0, qd0), self.applied
        q, qd = rollout(model.mechanism, start, model.laws, largest_step_s=self.step_s, finer=finer)
        shape = (*q0.shape[:2], *q.shape[1:])
        return q.reshape(shape), qd.reshape(shape)

    def compared(self, start_offsets: FloatArray, finer: int = 1) -> FloatArray:
        """(m, w, c, j) what is compared of those positions."""
        q, _ = self.rolled(start_offsets, finer)
        ends = np.cumsum([len(c.rows) for c in self.cuts])[:-1]
        seen = (self.applied.followed(self.windows.t_s, one, self.first_read) for one in q)
        return np.stack([_seen(np.split(one, ends), self.cuts) for one in seen])

    def step_error(self, start_offsets: FloatArray) -> FloatArray:
        """(w, c, j) what steps without length would change."""
        plain = self.compared(start_offsets[None])[0]
        shares = zip(_TO_NO_STEP[1:], (2, 4), strict=True)
        return np.sum(
            [share * (self.compared(start_offsets[None], finer)[0] - plain) for share, finer in shares], axis=0
        )

    def continued(self, start_offsets: FloatArray) -> tuple[FloatArray, np.ndarray]:
        """(w, j, 2) deviations at which the window before would have each begin, and (w,) whether one reaches it."""
        (q,), (qd,) = self.rolled(start_offsets[None])
        out, reached = start_offsets.copy(), np.zeros(len(start_offsets), dtype=bool)
        first = 0
        for piece in self.cuts:
            later = np.diff(piece.rows[:, 0])
            for k in np.flatnonzero(later < piece.rows.shape[1]):
                w, row = first + k + 1, later[k]
                out[w, :, 0] = (q[w - 1, row] - self.windows.q0[w]) / self.noise_q[w]
                out[w, :, 1] = (qd[w - 1, row] - self.windows.qd0[w]) / self.noise_qd[w]
                reached[w] = True
            first += len(piece.rows)
        return out, reached

    def linearised_at(self, start_offsets: FloatArray) -> tuple[FloatArray, FreeInitialStates]:
        """Compared positions at `start_offsets`, and their linearisation in each joint's position and rate."""
        ones = np.eye(start_offsets[0].size).reshape(-1, 1, *start_offsets.shape[1:])
        plain, *start_sensitivity = self.compared(np.concatenate([start_offsets[None], start_offsets + ones]))
        changes = np.stack(start_sensitivity, axis=-1) - plain[..., None]
        return plain, linearised_initial_states(changes, self.noise, np.zeros_like(plain))


def _seen(parts: Sequence[FloatArray], cuts: Sequence[Cut]) -> FloatArray:
    """(w, c, j) what is compared of positions (w, k, j) of each trial."""
    return np.concatenate([piece.of(part) for part, piece in zip(parts, cuts, strict=True)])


def _estimated_offsets(starts: _InitialStates, start_offsets: FloatArray, step_error: FloatArray) -> FloatArray:
    """(w, j, 2) deviations at which windows leave little more than noise; those that never do stay as they are.

    Sought from the readings by steps of Gauss and Newton, else from where an explained window before it leads.
    """
    tried, explained = start_offsets, np.zeros(len(start_offsets), dtype=bool)
    for _ in range(_SEARCHED):
        plain, free = starts.linearised_at(tried)
        errors = plain + step_error - starts.read
        left = np.sqrt(np.mean((free.without(errors) / starts.noise[:, None]) ** 2, axis=(1, 2)))
        step = (free.start_gain @ errors.reshape(len(errors), -1, 1)).reshape(tried.shape)
        better = left < _EXPLAINED
        start_offsets = np.where(better[:, None, None], tried - step, start_offsets)
        explained |= better
        if explained.all():
            break
        onwards, reached = starts.continued(start_offsets)
        led = ~explained & reached & np.roll(explained, 1)
        tried = np.where(led[:, None, None], onwards, tried - step)
    return start_offsets


def mean_noise(smooth: Smooth, piece: Cut) -> FloatArray:
    """(j,) noise of one of the compared means of readings."""
    return smooth.q_noise * np.sqrt(len(piece.compared) / piece.rows.shape[1])
