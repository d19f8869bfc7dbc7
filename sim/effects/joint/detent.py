"""Detent torque that repeats along the travel: detents, cogging of magnets, gear teeth."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointState, JointTorque
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.common.travel import COUNTS, count_bounds, count_start
from sim.effects.effect import Confusable, Effect, Parameter


def _torque(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    torque_Nm, count_per_rad, phase_rad = values[0], values[1], values[2]
    return -torque_Nm * np.sin(count_per_rad * state.q - phase_rad)


EFFECT = Effect(
    name="joint.detent",
    kinds=("mechanism",),
    formula="tau = -torque_Nm * sin(count_per_rad * q - phase_rad)",
    source="cogging: Hanselman, Brushless Permanent Magnet Motor Design, 2006, ch. 7",
    reveals="unexplained torque repeats over position, with the drive off as well",
    parameters=(
        Parameter("torque_Nm", "N m (N)", 0.0, 1e3, 0.0),
        Parameter("count_per_rad", "1/rad (1/m)", 0.5, 1e3, 6.0, is_shape=True, scan=COUNTS),
        Parameter("phase_rad", "rad", -np.pi, np.pi, 0.0, is_shape=True, is_phase=True),
    ),
    confusables=(
        Confusable("actuator.ripple", "let the joint swing with the drive off"),
        Confusable("joint.gravity_load", "move through a full turn: gravity repeats once"),
    ),
    hook=JointTorque(_torque, ("torque_Nm", "count_per_rad", "phase_rad")),
    mechanism=MechanismCandidacy(
        bounds=lambda r: {"torque_Nm": (0.0, r.torque), "count_per_rad": count_bounds(r)},
        start=lambda r: {"count_per_rad": count_start(r)},
    ),
    plot_against="position",
)
