"""Supply sag: the drive's effort falls with its logged supply voltage (V)."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.elementwise import where
from sim.dynamics.hooks import Confusable, Effect, EffortMap, JointState, Parameter


def _map(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    sag, nominal_V = values[0], values[1]
    share = np.maximum(0.0, 1.0 + sag * (state.supply_V / nominal_V - 1.0))
    return state.effort * where(np.isnan(state.supply_V), 1.0, share)


EFFECT = Effect(
    name="actuator.supply_sag",
    kinds=("mechanism",),
    formula="effort = asked * (1 + sag * (supply_V / nominal_V - 1))",
    source="voltage-driven DC motor; needs the side channel supply_V",
    reveals="the same command gives less when the logged supply is low",
    parameters=(Parameter("sag", "1", 0.0, 5.0, 0.0), Parameter("nominal_V", "V", 0.1, 1e3, 12.0)),
    confusables=(Confusable("actuator.gain", "let the supply vary at equal commands"),),
    hook=EffortMap(_map, ("sag", "nominal_V")),
)
