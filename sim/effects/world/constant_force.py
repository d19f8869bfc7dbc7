"""Constant force (N, world axes) at the mass centre: wind, a magnet, a cable."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import BodyState, BodyWrench, Params
from sim.effects.candidacy import TossCandidacy
from sim.effects.effect import Confusable, Effect, Parameter

_FORCE_SHARE = 0.5  # of the weight


def _wrench(state: BodyState, params: Params) -> tuple[FloatArray, FloatArray]:
    force = np.array([params["x_N"], params["y_N"], params["z_N"]])
    return np.broadcast_to(force, state.v.shape), np.zeros_like(state.v)


EFFECT = Effect(
    name="world.constant_force",
    kinds=("free_body",),
    formula="force = (x_N, y_N, z_N) at the mass centre",
    source="statics",
    reveals="the same unexplained acceleration everywhere",
    parameters=(
        Parameter("x_N", "N", -1e3, 1e3, 0.0),
        Parameter("y_N", "N", -1e3, 1e3, 0.0),
        Parameter("z_N", "N", -1e3, 1e3, 0.0),
    ),
    confusables=(
        Confusable("world.gravity_tilt", "change the mass"),
        Confusable("world.gravity_magnitude", "change the mass"),
    ),
    hook=BodyWrench(_wrench),
    free_body=TossCandidacy(
        bounds=lambda r: {f"{axis}_N": (-_FORCE_SHARE * r.weight_N, _FORCE_SHARE * r.weight_N) for axis in "xyz"},
        direct=("force_in_flight",),
        linked_direct=("force_in_flight",),
    ),
)
