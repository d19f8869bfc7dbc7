"""Actuator saturation: the magnitude of the drive's effort is at most a limit (N m, N)."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import EffortMap, JointState
from sim.effects.candidacy import Bounds, MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import JointRanges

_LEAST_EFFORT = 1e-9  # N m (N): no division by what was never commanded
_LOWEST_LIMIT, _HIGHEST_LIMIT = 0.1, 4.0  # limits that are searched, over the typical commanded effort
_LIMIT_SHARES = (
    0.2,
    0.35,
    0.5,
    0.65,
    0.8,
    0.95,
    1.1,
    1.3,
    1.6,
    2.0,
    2.5,
)  # of it: a limit above all efforts has no gradient


def _map(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    return np.minimum(np.maximum(state.effort, -values[0]), values[0])


def _bounds(r: JointRanges) -> Bounds:
    effort = max(r.effort, _LEAST_EFFORT)
    return {"limit_Nm": (_LOWEST_LIMIT * effort, _HIGHEST_LIMIT * effort)}


EFFECT = Effect(
    name="actuator.saturation",
    kinds=("mechanism", "tracking"),
    formula="|effort| <= limit_Nm",
    source="current limit of the drive",
    reveals="large efforts have no more effect than a certain one",
    parameters=(Parameter("limit_Nm", "N m (N)", 1e-4, 1e6, 1e6),),
    confusables=(Confusable("actuator.gain", "command small and large efforts: a gain scales both"),),
    hook=EffortMap(_map, ("limit_Nm",)),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.driven,
        null=lambda r: {"limit_Nm": _bounds(r)["limit_Nm"][1]},
        bounds=_bounds,
        extra_starts=lambda r, null, bounds: tuple(
            {"limit_Nm": share * r.effort} for share in _LIMIT_SHARES if r.effort
        ),
    ),
    plot_against="input",
    export=Export(usd="drive:angular:physics:maxForce", urdf="limit/@effort", urdf_joint={"limit_Nm": "effort"}),
)
