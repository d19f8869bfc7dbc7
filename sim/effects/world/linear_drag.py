"""Linear drag: resistance to a free body in proportion to its speed."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import BodyState, BodyWrench, Params
from sim.effects.candidacy import TossCandidacy
from sim.effects.effect import Confusable, Effect, Parameter


def _wrench(state: BodyState, params: Params) -> tuple[FloatArray, FloatArray]:
    return -params["drag_Nspm"] * state.v, np.zeros_like(state.v)


EFFECT = Effect(
    name="world.linear_drag",
    kinds=("free_body",),
    formula="force = -drag_Nspm * v",
    source="G. Stokes 1851",
    reveals="unexplained deceleration in flight grows with speed",
    parameters=(Parameter("drag_Nspm", "N s/m", 0.0, 100.0, 0.0),),
    confusables=(
        Confusable("world.quadratic_drag", "fly at speeds that differ by a factor of three"),
        Confusable("world.gravity_magnitude", "throw upwards and let fall"),
    ),
    hook=BodyWrench(_wrench),
    free_body=TossCandidacy(
        bounds=lambda r: {"drag_Nspm": (0.0, r.weight_N / r.speed)},
        direct=("drag_in_flight",),
        linked_direct=("drag_in_flight",),
    ),
)
