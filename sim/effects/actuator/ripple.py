"""Torque ripple: the drive's effort varies with the position of the rotor."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import EffortMap, JointState
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.common.travel import COUNTS, count_bounds, count_start
from sim.effects.effect import Confusable, Effect, Parameter


def _map(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    share, count_per_rad, phase_rad = values[0], values[1], values[2]
    return state.effort * (1.0 + share * np.sin(count_per_rad * state.q - phase_rad))


EFFECT = Effect(
    name="actuator.ripple",
    kinds=("mechanism", "tracking"),
    formula="effort = asked * (1 + share * sin(count_per_rad * q - phase_rad))",
    source="torque ripple: Hanselman, Brushless Permanent Magnet Motor Design, 2006, ch. 7",
    reveals="unexplained torque repeats over position and grows with effort",
    parameters=(
        Parameter("share", "1", 0.0, 1.0, 0.0),
        Parameter("count_per_rad", "1/rad (1/m)", 0.5, 1e3, 6.0, is_shape=True, scan=COUNTS),
        Parameter("phase_rad", "rad", -np.pi, np.pi, 0.0, is_shape=True, is_phase=True),
    ),
    confusables=(Confusable("joint.detent", "let the joint swing with the drive off"),),
    hook=EffortMap(_map, ("share", "count_per_rad", "phase_rad")),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.driven,
        bounds=lambda r: {"count_per_rad": count_bounds(r)},
        start=lambda r: {"count_per_rad": count_start(r)},
    ),
    plot_against="input",
)
