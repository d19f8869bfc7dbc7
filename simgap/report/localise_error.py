"""Shares of the error by phase, speed, position, effort and axis, from residuals and the measured state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.sim_gap.report import Localisation
from simgap.inference.robust_least_squares import CAUCHY_SCALE
from simgap.problem import EventProblem, Model, Problem
from simgap.whole_trials.policy import POLICY

_LEFT_NOISE = 5.0  # noise levels
_MOST_ROWS = 8
_CONTRAST_DRAWS = 400  # of trials, for the lower bound of a contrast
_NEAR_M = 0.004  # lowest point this close to the support: touching
_SLOW_MPS, _SLOW_RADPS = 0.02, 0.2
_ROLLS = 0.25  # slip over speed below which contact rolls
Slices = dict[tuple[str, str], BoolArray]  # (phase, axis) -> mask (k, c)


@dataclass(frozen=True)
class _Loss:
    """Loss (n, c) per row and channel of all trials, 0 where nothing was `seen`; `trials` (n,) numbers of the rows."""

    loss: FloatArray
    seen: BoolArray
    trials: IntArray

    def per_trial(self, mask: BoolArray) -> FloatArray:
        """(2, t) summed loss and number of readings within a mask (n, c)."""
        count = int(self.trials.max()) + 1
        sums = [np.where(mask & self.seen, v, 0.0).sum(axis=1) for v in (self.loss, np.ones_like(self.loss))]
        return np.stack([np.bincount(self.trials, v, count).astype(np.float64) for v in sums])

    def contrast(self, inside: BoolArray, frame: BoolArray) -> Contrast:
        """Mean loss of a reading `inside` over that of one in the rest of `frame`; its lower bound over trials."""
        within, rest = self.per_trial(inside), self.per_trial(frame & ~inside)
        draws = np.random.default_rng(0).integers(0, within.shape[1], (_CONTRAST_DRAWS, within.shape[1]))
        drawn = _ratio(within[:, draws].sum(axis=2), rest[:, draws].sum(axis=2))
        whole = float(_ratio(within.sum(axis=1), rest.sum(axis=1)))
        return Contrast(whole, float(np.quantile(drawn, POLICY.alpha)))


class Contrast(NamedTuple):
    """How much more error a reading of a slice holds than one outside, and the lower 95 % bound of that."""

    value: float
    lower: float


def localise_error(
    problem: Problem, model: Model, trials: Sequence[str], joints: Sequence[str] = ()
) -> tuple[Localisation, ...]:
    """The slices that clearly hold more error than their share of the readings, most first.

    Slices of bodies are phases, those of joints bands; each is compared with the rest of its axis, and an axis with the
    other axes. A slice is a place of the error only where the lower 95 % bound of its contrast over trials reaches
    `POLICY.contrast`: 41 % of the error in 40 % of the time say nothing.
    joints   names of the joints of a mechanism; none for a free body.
    """
    view = "short_horizon"
    floor = np.maximum(problem.noise_floor(trials, view), 1e-12)
    errors = problem.residuals(model, trials, view)
    error = np.concatenate(errors) / floor
    features = np.concatenate(problem.features(trials, view))
    seen = np.isfinite(error)
    # Diverged roll-outs must not outweigh all others, and large errors must still count by their size.
    scale = CAUCHY_SCALE * max(1.0, 1.4826 * float(np.median(np.abs(error[seen]))) if seen.any() else 1.0)
    loss = np.where(seen, np.log1p((np.nan_to_num(error) / scale) ** 2), 0.0)
    losses = _Loss(loss, seen, np.repeat(np.arange(len(errors)), [len(e) for e in errors]))
    events = problem.as_events()
    if events is not None:
        slices, starts = _event_slices(events, features), [None] * len(floor)
    else:
        slices = _joint_slices(features, joints) if joints else _body_slices(features, problem.channels())
        starts = _first_divergence(problem, model, trials)
    rows = []
    for (phase, axis), mask, frame in _with_frames(slices, seen):
        contrast = losses.contrast(mask, frame)
        if not contrast.lower >= POLICY.contrast:
            continue
        ratio = float(np.sqrt((np.clip(error[mask], -1e3, 1e3) ** 2).mean()))
        first = [s for s, c in zip(starts, np.atleast_1d(mask.any(axis=0)), strict=True) if c and s is not None]
        rows.append(
            Localisation(
                what=f"{axis}: {phase}" if phase else axis,
                share_of_error=float(loss[mask].sum()) / max(float(loss.sum()), 1e-300),
                share_of_time=float(mask.sum()) / float(seen.sum()),
                first_divergence_s=min(first) if first else None,
                phase=phase,
                axis=axis,
                noise_ratio=ratio,
                contrast=contrast.value,
            )
        )
    rows.sort(key=lambda r: (r.share_of_time - r.share_of_error, r.what))
    return tuple(rows[:_MOST_ROWS])


def _with_frames(slices: Slices, seen: BoolArray) -> Iterator[tuple[tuple[str, str], BoolArray, BoolArray]]:
    """Each slice that was seen, with what it is compared with; first each axis as a whole, with all axes."""
    axes: dict[str, BoolArray] = {}
    for (_, axis), mask in slices.items():
        axes[axis] = axes.get(axis, np.zeros_like(seen)) | (mask & seen)
    for axis, whole in axes.items():
        if whole.any() and not whole[seen].all():
            yield ("", axis), whole, seen
    for (phase, axis), mask in slices.items():
        inside = mask & seen
        if inside.any() and not np.array_equal(inside, axes[axis]):
            yield (phase, axis), inside, axes[axis]


def _ratio(within: FloatArray, rest: FloatArray) -> FloatArray:
    """Mean loss within over that of the rest, from sums and counts (2, ...); 1 where one of them has no readings."""
    known = (within[1] > 0.0) & (rest[1] > 0.0)
    means = [values[0] / np.maximum(values[1], 1.0) for values in (within, rest)]
    return np.where(known, means[0] / np.maximum(means[1], 1e-300), 1.0)


def _first_divergence(problem: Problem, model: Model, trials: Sequence[str]) -> list[float | None]:
    """Per channel: seconds into a full roll-out until the error stays above the noise, median over trials."""
    floor = np.maximum(problem.noise_floor(trials, "full_rollout"), 1e-12)
    times: list[list[float]] = [[] for _ in floor]
    residuals = problem.residuals(model, trials, "full_rollout")
    for error, features in zip(residuals, problem.features(trials, "full_rollout"), strict=True):
        beyond = ~(np.abs(error / floor) <= _LEFT_NOISE)
        for c, divergence_s in enumerate(times):
            inside = np.flatnonzero(~beyond[:, c])
            last = inside[-1] + 1 if len(inside) else 0
            if last < len(error):
                divergence_s.append(float(features[last, -1]))
    return [
        float(np.median(divergence_s)) if len(divergence_s) * 2 > len(residuals) else None for divergence_s in times
    ]


def _event_slices(problem: EventProblem, features: FloatArray) -> Slices:
    """Kinds of events against channels."""
    names = problem.channels()
    return {
        (phase, name): rows[:, None] & (np.arange(len(names)) == c)
        for phase, rows in problem.slices(features).items()
        for c, name in enumerate(names)
    }


def _joint_slices(features: FloatArray, joints: Sequence[str]) -> Slices:
    """Direction, speed, position and effort bands of every joint; columns of `features` as the problem gives them."""
    n = len(joints)
    slices: Slices = {}
    for j, name in enumerate(joints):
        q, qd = features[:, j], features[:, n + j]
        speed = np.abs(qd)
        slow, fast = np.quantile(speed, [0.2, 0.8])
        low, high = q.min() + np.ptp(q) / 3.0, q.max() - np.ptp(q) / 3.0
        bands = {
            f"moving forward (over {slow:.2g})": qd > slow,
            f"moving backward (over {slow:.2g})": qd < -slow,
            f"near standstill (under {slow:.2g})": speed <= slow,
            f"fast (over {fast:.2g})": speed >= fast,
            f"positions below {low:.2g}": q < low,
            f"positions from {low:.2g} to {high:.2g}": (q >= low) & (q <= high),
            f"positions above {high:.2g}": q > high,
        }
        if features.shape[1] > 2 * n + 1:
            effort = np.abs(features[:, 2 * n + j])
            strong = np.quantile(effort, 0.8)
            bands |= {f"strong input (over {strong:.2g})": effort >= strong, "weak input": effort < strong}
        column = np.arange(n) == j
        slices |= {(phase, name): rows[:, None] & column for phase, rows in bands.items()}
    return slices


def _body_slices(features: FloatArray, channels: Sequence[str]) -> Slices:
    """Phases of a tossed body against groups of axes."""
    axes = {
        "horizontal position": [c in ("position_x", "position_y") for c in channels],
        "vertical position": [c == "position_z" for c in channels],
        "rotation": [c.startswith("rotation") for c in channels],
        **{f"joint {c[2:]}": [c == other for other in channels] for c in channels if c.startswith("q_")},
    }
    phases = body_phases(features)
    return {
        (phase, axis): (phases == phase)[:, None] & np.array(columns)
        for phase in np.unique(phases)
        for axis, columns in axes.items()
    }


def body_phases(features: FloatArray) -> FloatArray:
    """(k,) flight, impact, sliding, rolling or rest: velocity (3), turning rate (3), gap (1) at the start, time since.

    A body that would fall below the support before the compared row meets it: that row is an impact.
    """
    v, w, gap, since = features[:, :3], features[:, 3:6], features[:, 6], features[:, -1]
    ahead = gap + v[:, 2] * since - 0.5 * GRAVITY_MPS2 * since**2
    touching = gap <= _NEAR_M
    level, turning = np.linalg.norm(v[:, :2], axis=1), np.linalg.norm(w[:, :2], axis=1)
    # Rolling ties the directions: the axis of turning stands across the velocity.
    across = np.abs(v[:, 0] * w[:, 1] - v[:, 1] * w[:, 0])
    tied = across > (1.0 - _ROLLS) * level * turning
    moving = (level > _SLOW_MPS) | (np.linalg.norm(w, axis=1) > _SLOW_RADPS)
    rolls = tied & (turning > _SLOW_RADPS) & (level > _SLOW_MPS)
    return np.select(
        [~touching & (ahead > _NEAR_M), ~touching, ~moving, rolls],
        ["flight", "impact", "rest", "rolling or tipping"],
        "sliding",
    )
