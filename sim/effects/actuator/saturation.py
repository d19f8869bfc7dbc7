"""Actuator saturation: the magnitude of the drive's effort is at most a limit (N m, N)."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Confusable, Effect, EffortMap, JointState, Parameter


def _map(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    return np.minimum(np.maximum(state.effort, -values[0]), values[0])


EFFECT = Effect(
    name="actuator.saturation",
    kinds=("mechanism", "tracking"),
    formula="|effort| <= limit_Nm",
    source="current limit of the drive",
    reveals="large efforts have no more effect than a certain one",
    parameters=(Parameter("limit_Nm", "N m (N)", 1e-4, 1e6, 1e6),),
    confusables=(Confusable("actuator.gain", "command small and large efforts: a gain scales both"),),
    hook=EffortMap(_map, ("limit_Nm",)),
    usd="drive:angular:physics:maxForce",
    urdf="limit/@effort",
)
