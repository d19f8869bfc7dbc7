"""Shares of the error by phase, speed, position, effort and axis, from residuals and the measured state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.arrays import FloatArray
from schemas.gap import Localisation
from schemas.physical_constants import GRAVITY_MPS2
from simgap.inference.robust_least_squares import CAUCHY_SCALE
from simgap.problem import EventProblem, Model, Problem

_DIVERGED = 5.0  # noise levels
_MOST_ROWS = 8
_NEAR_M = 0.004  # lowest point this close to the support: touching
_SLOW_MPS, _SLOW_RADPS = 0.02, 0.2
_ROLLS = 0.25  # slip over speed below which contact rolls
Slices = dict[tuple[str, str], FloatArray]  # (phase, axis) -> mask (k, c)


def localise_error(
    problem: Problem, model: Model, trials: Sequence[str], joints: Sequence[str] = ()
) -> tuple[Localisation, ...]:
    """The slices that hold more error than time, most first; those of bodies are phases, those of joints bands.

    joints   names of the joints of a mechanism; none for a free body.
    """
    view = "short_horizon"
    floor = np.maximum(problem.noise_floor(trials, view), 1e-12)
    error = np.concatenate(problem.residuals(model, trials, view)) / floor
    features = np.concatenate(problem.features(trials, view))
    seen = np.isfinite(error)
    loss = np.where(seen, CAUCHY_SCALE**2 * np.log1p((np.nan_to_num(error) / CAUCHY_SCALE) ** 2), 0.0)
    total = max(float(loss.sum()), 1e-300)
    events = problem.as_events()
    if events is not None:
        slices, starts = _event_slices(events, features), [None] * len(floor)
    else:
        slices = _joint_slices(features, joints) if joints else _body_slices(features, problem.channels())
        starts = _first_divergence(problem, model, trials)
    rows = []
    for (phase, axis), mask in slices.items():
        mask = mask & seen
        if not mask.any():
            continue
        ratio = float(np.sqrt((np.clip(error[mask], -1e3, 1e3) ** 2).mean()))
        columns = np.atleast_1d(mask.any(axis=0))
        first = [s for s, c in zip(starts, columns, strict=True) if c and s is not None]
        rows.append(
            Localisation(
                what=f"{axis}: {phase}",
                share_of_error=float(loss[mask].sum()) / total,
                share_of_time=float(mask.sum()) / float(seen.sum()),
                first_divergence_s=min(first) if first else None,
                phase=phase,
                axis=axis,
                noise_ratio=ratio,
            )
        )
    rows.sort(key=lambda r: (r.share_of_time - r.share_of_error, r.what))
    return tuple(rows[:_MOST_ROWS])


def _first_divergence(problem: Problem, model: Model, trials: Sequence[str]) -> list[float | None]:
    """Per channel: seconds into a full roll-out until the error stays above the noise, median over trials."""
    floor = np.maximum(problem.noise_floor(trials, "full_rollout"), 1e-12)
    times: list[list[float]] = [[] for _ in floor]
    residuals = problem.residuals(model, trials, "full_rollout")
    for error, features in zip(residuals, problem.features(trials, "full_rollout"), strict=True):
        beyond = ~(np.abs(error / floor) <= _DIVERGED)
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
