"""Actuator bias: the drive adds a constant effort (N m, N), also at zero command."""

from __future__ import annotations

from schemas.arrays import FloatArray
from sim.dynamics.hooks import EffortMap, JointState, Params
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter


def _map(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    return state.effort + params["torque_Nm"]


EFFECT = Effect(
    name="actuator.bias",
    kinds=("mechanism", "tracking"),
    formula="effort = asked effort + torque_Nm",
    source="amplifier offset; EMPS benchmark, Janot, Gautier, Brunot, 2019",
    reveals="unexplained torque is constant over position, speed and direction",
    parameters=(Parameter("torque_Nm", "N m (N)", -1e3, 1e3, 0.0),),
    confusables=(
        Confusable("joint.friction_asymmetry", "hold still, or let it swing with the drive off"),
        Confusable("joint.axis_tilt", "move over the whole range: gravity depends on position"),
    ),
    hook=EffortMap(_map),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.driven,
        bounds=lambda r: {"torque_Nm": (-r.torque, r.torque)},
    ),
)
