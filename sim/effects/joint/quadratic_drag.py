"""Quadratic drag: resistance of the air to a turning link, in proportion to the square of its rate."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointState, JointTorque, Params
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter


def _torque(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    return -params["drag_Nms2_per_rad2"] * state.qd * np.abs(state.qd)


EFFECT = Effect(
    name="joint.quadratic_drag",
    kinds=("mechanism",),
    formula="tau = -drag_Nms2_per_rad2 * qd * |qd|",
    source="Lord Rayleigh, Phil. Mag. 2, 1876",
    reveals="large swings lose amplitude faster, in proportion to its square",
    parameters=(Parameter("drag_Nms2_per_rad2", "N m s2/rad2 (N s2/m2)", 0.0, 1e3, 0.0),),
    confusables=(Confusable("joint.viscous_friction", "move at speeds that differ by a factor of three or more"),),
    hook=JointTorque(_torque),
    mechanism=MechanismCandidacy(bounds=lambda r: {"drag_Nms2_per_rad2": (0.0, r.torque / r.speed**2)}),
)
