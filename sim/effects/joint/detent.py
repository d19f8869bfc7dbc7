"""Detent torque that repeats along the travel: detents, cogging of magnets, gear teeth."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointState, JointTorque, Params
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.common.travel import count_bounds, count_start
from sim.effects.effect import Confusable, Effect, Parameter


def _torque(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    return -params["torque_Nm"] * np.sin(params["count_per_rad"] * state.q - params["phase_rad"])


EFFECT = Effect(
    name="joint.detent",
    kinds=("mechanism",),
    formula="tau = -torque_Nm * sin(count_per_rad * q - phase_rad)",
    source="cogging: Hanselman, Brushless Permanent Magnet Motor Design, 2006, ch. 7",
    reveals="unexplained torque repeats over position, with the drive off as well",
    parameters=(
        Parameter("torque_Nm", "N m (N)", 0.0, 1e3, 0.0),
        Parameter("count_per_rad", "1/rad (1/m)", 0.5, 1e3, 6.0, is_shape=True),
        Parameter("phase_rad", "rad", -np.pi, np.pi, 0.0, is_shape=True),
    ),
    confusables=(
        Confusable("actuator.ripple", "let the joint swing with the drive off"),
        Confusable("joint.gravity_load", "move through a full turn: gravity repeats once"),
    ),
    hook=JointTorque(_torque),
    mechanism=MechanismCandidacy(
        bounds=lambda r: {"torque_Nm": (0.0, r.torque), "count_per_rad": count_bounds(r)},
        start=lambda r: {"count_per_rad": count_start(r)},
    ),
    plot_against="position",
)
