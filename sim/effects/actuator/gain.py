"""Actuator gain: the drive's effort is a multiple of the commanded effort."""

from __future__ import annotations

from schemas.arrays import FloatArray
from sim.dynamics.hooks import EffortMap, JointState, Params
from sim.effects.candidacy import MechanismCandidacy, within
from sim.effects.effect import Confusable, Effect, Parameter
from sim.effects.ranges import TOLERANCE


def _map(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    return params["gain"] * state.effort


EFFECT = Effect(
    name="actuator.gain",
    kinds=("mechanism", "tracking"),
    formula="effort = gain * asked effort",
    source="motor constant or calibration error",
    reveals="unexplained torque in proportion to the effort",
    parameters=(Parameter("gain", "1", 0.05, 5.0, 1.0),),
    confusables=(
        Confusable("joint.armature", "hang a known load on the joint: gravity is a reference for effort"),
        Confusable("joint.spring", "let the joint swing with the drive off"),
        Confusable("actuator.supply_sag", "log the supply voltage"),
    ),
    hook=EffortMap(_map),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.driven,
        nuisance=lambda joint: within("effort", "gain", 1.0, TOLERANCE if joint.driven else 0.0),
    ),
    plot_against="input",
)
