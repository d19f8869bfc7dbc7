"""Quadratic drag: resistance of the air to a free body, in proportion to the square of its speed."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import BodyState, BodyWrench, Params
from sim.effects.candidacy import TossCandidacy
from sim.effects.effect import Confusable, Effect, Parameter


def _wrench(state: BodyState, params: Params) -> tuple[FloatArray, FloatArray]:
    speed = np.linalg.norm(state.v, axis=1, keepdims=True)
    return -params["drag_Ns2pm2"] * speed * state.v, np.zeros_like(state.v)


EFFECT = Effect(
    name="world.quadratic_drag",
    kinds=("free_body",),
    formula="force = -drag_Ns2pm2 * |v| v; drag = density * drag coefficient * area / 2",
    source="Lord Rayleigh 1876",
    reveals="unexplained deceleration in flight grows with the square of speed",
    parameters=(Parameter("drag_Ns2pm2", "N s2/m2", 0.0, 100.0, 0.0),),
    confusables=(
        Confusable("world.linear_drag", "fly at speeds that differ by a factor of three"),
        Confusable("world.gravity_magnitude", "throw upwards and let fall"),
    ),
    hook=BodyWrench(_wrench),
    free_body=TossCandidacy(
        bounds=lambda r: {"drag_Ns2pm2": (0.0, r.weight_N / r.speed**2)},
        direct=("quadratic_drag_in_flight",),
        linked_direct=("quadratic_drag_in_flight",),
    ),
)
