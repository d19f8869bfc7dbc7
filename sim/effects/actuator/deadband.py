"""Actuator dead band: the drive ignores small efforts and shortens larger ones by the band (N m, N)."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Confusable, Effect, EffortMap, JointState, Parameter


def _map(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    return np.sign(state.effort) * np.maximum(np.abs(state.effort) - values[0], 0.0)


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
    hook=EffortMap(_map, ("band_Nm",)),
)
