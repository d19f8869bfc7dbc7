"""Supply sag: the drive's effort falls with its logged supply voltage (V)."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import EffortMap, JointState, Params
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter

_CHANNEL = "supply_V"
# Of the supply's median: where a drive gives the commanded effort. A supply may sag all the time.
_LOWEST_NOMINAL, _HIGHEST_NOMINAL = 0.9, 1.6


def _map(state: JointState, params: Params, memory: dict[str, FloatArray]) -> FloatArray:
    volts = state.aux.get("supply_V")
    if volts is None:
        return state.effort
    return state.effort * np.maximum(0.0, 1.0 + params["sag"] * (volts / params["nominal_V"] - 1.0))


EFFECT = Effect(
    name="actuator.supply_sag",
    kinds=("mechanism",),
    formula="effort = asked * (1 + sag * (supply_V / nominal_V - 1))",
    source="voltage-driven DC motor; needs the side channel supply_V",
    reveals="the same command gives less when the logged supply is low",
    parameters=(Parameter("sag", "1", 0.0, 5.0, 0.0), Parameter("nominal_V", "V", 0.1, 1e3, 12.0, is_shape=True)),
    confusables=(Confusable("actuator.gain", "let the supply vary at equal commands"),),
    hook=EffortMap(_map),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.driven and _CHANNEL in r.side_channels,
        null=lambda r: {"nominal_V": r.side_channels[_CHANNEL]},
        bounds=lambda r: {
            "nominal_V": (_LOWEST_NOMINAL * r.side_channels[_CHANNEL], _HIGHEST_NOMINAL * r.side_channels[_CHANNEL])
        },
    ),
)
