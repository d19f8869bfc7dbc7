"""Play between drive and joint."""

from __future__ import annotations

import numpy as np

from schemas.model import FloatArray
from sim.effects.effect import Confusable, Effect, EffortMap, JointState, Parameter, Params


def _map(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    """Effort passes only while the drive touches the flank it pushes; it crosses the gap at its own free rate."""
    side = np.sign(state.effort)
    play = memory.get("play", 0.5 * params["gap_rad"] * side)  # drive minus joint, within half the gap
    rate = side * params["crossing_radps"] - state.qd
    moved = np.clip(play + rate * state.dt_s, -0.5 * params["gap_rad"], 0.5 * params["gap_rad"])
    memory["play"] = moved
    touching = np.abs(moved - 0.5 * params["gap_rad"] * side) < 1e-9
    return np.where(touching, state.effort, 0.0)


EFFECT = Effect(
    name="joint.backlash",
    kinds=("mechanism",),
    formula="no effort while the drive crosses gap_rad after a reversal, at crossing_radps",
    source="Nordin and Gutman, Automatica 38(10), 2002 (dead-zone model with a light drive)",
    reveals="after each reversal of effort the joint waits, longer at low speed",
    parameters=(
        Parameter("gap_rad", "rad (m)", 0.0, 0.5, 0.0),
        Parameter("crossing_radps", "rad/s (m/s)", 0.05, 50.0, 2.0),
    ),
    confusables=(
        Confusable("actuator.delay", "reverse at several speeds: a delay is a time, play is an angle"),
        Confusable("actuator.deadband", "hold a small steady effort: play passes it, a dead band does not"),
        Confusable("sensor.latency", "reverse at several speeds"),
    ),
    hook=EffortMap(_map),
)
