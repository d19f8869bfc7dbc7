"""Actuator dead band: the drive ignores small efforts and shortens larger ones by the band (N m, N)."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import EffortMap, JointState, Params
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter

_LEAST_EFFORT = 1e-9  # N m (N): no division by what was never commanded


def _map(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    return np.sign(state.effort) * np.maximum(np.abs(state.effort) - params["band_Nm"], 0.0)


EFFECT = Effect(
    name="actuator.deadband",
    kinds=("mechanism", "tracking"),
    formula="effort = sign(asked) * max(|asked| - band_Nm, 0)",
    source="amplifier dead zone",
    reveals="small efforts do nothing, large ones lack a constant",
    parameters=(Parameter("band_Nm", "N m (N)", 0.0, 1e3, 0.0),),
    confusables=(
        Confusable("joint.coulomb_friction", "let the joint swing with the drive off"),
        Confusable("joint.backlash", "hold a small steady effort"),
    ),
    hook=EffortMap(_map),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.driven,
        bounds=lambda r: {"band_Nm": (0.0, max(r.effort, _LEAST_EFFORT))},
    ),
    plot_against="input",
)
