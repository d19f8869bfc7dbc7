"""Roll-outs with their starts left free: what a wrong start does to a window is no error of the model.

A start is read off noisy positions, its rate worst of all: over a second that noise outgrows what most causes do. Each
window's start may move by what its readings say (output error with free initial conditions: Ljung, System
Identification, 1999, section 7.4), to first order, so that no further roll-out is needed (Golub and Pereyra, SIAM J.
Numer. Anal. 10, 1973). What steps of finite length leave is taken out in the same way, once for all candidates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.model import FloatArray
from sim.effects.effect import Series
from sim.mechanism import Windows, rollout
from simgap.mechanism.smooth import Smooth
from simgap.mechanism.terms import Applied
from simgap.mechanism.windows import Cut, windows_of

_HELD = 0.01  # precision with which a start is held, of its noise's: smoothing rounds it besides
# Of motions with the step, half of it and a quarter: errors of first and second order in the step cancel (Richardson).
_TO_NO_STEP = (1.0 / 3.0, -2.0, 8.0 / 3.0)


@dataclass(frozen=True)
class FreeStarts:
    """Windows (w) whose starts follow their errors (w, c, j), which are flattened to c * j.

    moved     (w, c * j, s) change of the errors by one deviation of each of the s numbers of a start
    followed  (w, s, c * j) deviations by which a start follows errors; far beyond its noise it is held back
    by_steps  (w, c, j) what finer steps change
    """

    moved: FloatArray
    followed: FloatArray
    by_steps: FloatArray

    def without(self, errors: FloatArray) -> FloatArray:
        """(w, c, j) what is left of errors (w, c, j), with finer steps, once each start is where that is least."""
        flat = (errors + self.by_steps).reshape(len(errors), -1, 1)
        return (flat - self.moved @ (self.followed @ flat)).reshape(errors.shape)


def free_starts(changes: FloatArray, noise: FloatArray, by_steps: FloatArray) -> FreeStarts:
    """From `changes` (w, c, j, s) of what is compared by one deviation of each number of a start, and noise (j,)."""
    windows, compared, joints, numbers = changes.shape
    moved = changes.reshape(windows, compared * joints, numbers)
    weighted = np.swapaxes(moved, 1, 2) / np.tile(noise**2, compared)
    return FreeStarts(moved, np.linalg.solve(weighted @ moved + _HELD * np.eye(numbers), weighted), by_steps)


def starts_of(
    applied: Applied, pieces: Sequence[tuple[Series, Cut]], smooth: Sequence[Smooth], step_s: float
) -> list[FreeStarts]:
    """Per trial, what a model makes of wrong starts of its windows: each joint's place and rate, one after another."""
    windows = windows_of(pieces, applied)
    ends = np.cumsum([len(piece.rows) for _, piece in pieces])[:-1]

    def compared(start: Windows, finer: int = 1) -> list[FloatArray]:
        q, _ = rollout(applied.mechanism, start, applied.laws, largest_step_s=step_s, finer=finer)
        return [piece.of(part) for part, (_, piece) in zip(np.split(q, ends), pieces, strict=True)]

    plain, *finer = (compared(windows, 2**k) for k in range(len(_TO_NO_STEP)))
    noise_q, noise_qd = (
        np.concatenate([np.tile(of(s), (len(piece.rows), 1)) for s, (_, piece) in zip(smooth, pieces, strict=True)])
        for of in (lambda s: s.kept * s.q_noise, lambda s: s.qd_noise)
    )
    moved = [
        compared(start)
        for one in np.eye(windows.q0.shape[1])
        for start in (
            replace(windows, q0=windows.q0 + noise_q * one),
            replace(windows, qd0=windows.qd0 + noise_qd * one),
        )
    ]
    return [
        free_starts(
            np.stack([m[k] - plain[k] for m in moved], axis=-1),
            mean_noise(smooth[k], piece),
            np.sum([share * (fine[k] - plain[k]) for share, fine in zip(_TO_NO_STEP[1:], finer, strict=True)], axis=0),
        )
        for k, (_, piece) in enumerate(pieces)
    ]


def mean_noise(smooth: Smooth, piece: Cut) -> FloatArray:
    """(j,) noise of one of the compared means of readings."""
    return smooth.q_noise * np.sqrt(len(piece.compared) / piece.rows.shape[1])
