"""A driven pendulum or slide as ordinary differential equations of its own; shares no code with the library.

All trials at once, half a millisecond or less per step (leapfrog); dry friction stops a joint within a step when it
can, or is a field of bristles (Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40(3), 1995: LuGre).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

STEP_S = 2.5e-4


@dataclass(frozen=True)
class Plant:
    """The thing itself, as its owner believes it: inertia (kg m2 or kg), m g l (N m, 0 for a slide), drive."""

    inertia: float
    weight_Nm: float
    drive: str  # none | effort | position_pd
    kp: float = 0.0
    kd: float = 0.0
    friction: float = 0.0
    damping: float = 0.0


def simulate(plant: Plant, hidden: dict[str, float], inputs: np.ndarray, start: np.ndarray, row_s: float) -> np.ndarray:
    """Angles (trials, rows) under `inputs` (trials, rows), held from row to row, from `start` (trials, 2)."""
    h = hidden.get
    trials, rows = inputs.shape
    q, v = start[:, 0].copy(), start[:, 1].copy()
    every = round(row_s / STEP_S)
    late = round(h("delay_s", 0.0) / STEP_S)
    inertia = plant.inertia * (1.0 + h("inertia_share", 0.0))
    weight = plant.weight_Nm * (1.0 + h("weight_share", 0.0))
    bristle, lagged, play = np.zeros(trials), np.zeros(trials), np.zeros(trials)
    out = np.empty((trials, rows))
    lag = h("lag_s", 0.0)
    for step in range(rows * every):
        if step % every == 0:
            out[:, step // every] = q
        sent = inputs[:, max(step - late, 0) // every]
        q = q + 0.5 * STEP_S * v
        if lag:
            lagged = sent if step == 0 else lagged + (1.0 - np.exp(-STEP_S / lag)) * (sent - lagged)
            sent = lagged
        asked = plant.kp * (sent - q) - plant.kd * v if plant.drive == "position_pd" else sent
        drive, play = _drive(plant, h, asked, q, v, play)
        torque = drive - weight * np.sin(q + h("tilt_rad", 0.0)) - _smooth(h, q, v)
        torque = torque - (plant.damping * (1.0 + h("damping_share", 0.0)) + h("viscous", 0.0)) * v
        if h("lugre", 0.0):
            z_rate = v - np.abs(v) * bristle / _lugre_depth(h, v)
            bristle = np.clip(bristle + STEP_S * z_rate, -2e-3, 2e-3)
            torque = torque - h("lugre", 0.0) / 1e-3 * bristle
        free = v + STEP_S * torque / inertia
        limit = _dry(plant, h, q, v, free) * STEP_S / inertia
        v = np.where(np.abs(free) <= limit, 0.0, free - np.sign(free) * limit)
        q = q + 0.5 * STEP_S * v
    return out


def _drive(plant, h, asked, q, v, play):
    if plant.drive == "none":
        return np.zeros_like(q), play
    effort = np.minimum(np.maximum(asked, -h("limit", 1e9)), h("limit", 1e9))
    band = h("band", 0.0)
    effort = np.where(effort > band, effort - band, np.where(effort < -band, effort + band, 0.0))
    effort = effort * (1.0 + h("gain_share", 0.0)) * (1.0 + h("ripple", 0.0) * np.cos(h("teeth", 1.0) * q + 0.7))
    if h("gap", 0.0):
        side = np.where(effort >= 0.0, 1.0, -1.0)
        play = np.clip(play + STEP_S * (3.0 * side - v), -0.5 * h("gap"), 0.5 * h("gap"))
        effort = np.where(np.abs(play * side - 0.5 * h("gap")) < 1e-9, effort, 0.0)
    return effort + h("push", 0.0), play


def _smooth(h, q, v):
    torque = h("drag", 0.0) * v * np.abs(v) + h("spring", 0.0) * (q - h("rest", 0.0))
    over = np.maximum(q - h("stop_rad", 1e9), 0.0)
    return torque + h("stop_stiffness", 0.0) * over + h("cogging", 0.0) * np.cos(h("teeth", 1.0) * q + 0.4)


def _dry(plant, h, q, v, free):
    limit = plant.friction * (1.0 + h("friction_share", 0.0)) + h("coulomb", 0.0)
    limit = limit + h("stribeck", 0.0) / (1.0 + (v / h("stribeck_radps", 1.0)) ** 2)
    pull = np.hypot(plant.weight_Nm * np.cos(q) + 0.9 * plant.inertia * v**2, plant.weight_Nm * np.sin(q))
    limit = limit + h("load_share", 0.0) * pull
    return np.maximum(limit + h("asymmetry", 0.0) * np.sign(free), 0.0)


def _lugre_depth(h, v):
    """Steady bristle deflection (m or rad): 30 % more at rest than in motion."""
    return 1e-3 * (1.0 + 0.3 * np.exp(-((v / 0.1) ** 2)))
