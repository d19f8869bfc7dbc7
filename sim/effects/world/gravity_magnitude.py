"""Gravity magnitude (m/s2) that differs from that of the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.physical_constants import GRAVITY_MPS2
from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    down = model.gravity_W / np.linalg.norm(model.gravity_W)
    return replace(model, gravity_W=params["gravity_mps2"] * down)


EFFECT = Effect(
    name="world.gravity_magnitude",
    kinds=("free_body",),
    formula="|g| = gravity_mps2",
    source="free fall",
    reveals="free fall is too fast or too slow",
    parameters=(Parameter("gravity_mps2", "m/s2", 0.1, 30.0, GRAVITY_MPS2),),
    confusables=(
        Confusable("sensor.scale", "measure a known length"),
        Confusable("sensor.clock_skew", "time the log with a second clock"),
        Confusable("world.linear_drag", "fall longer: drag grows with speed"),
    ),
    hook=ModelChange(_change),
    free_body=TossCandidacy(
        null=lambda r: {"gravity_mps2": float(np.linalg.norm(r.body.gravity_W))},
        bounds=lambda r: {"gravity_mps2": (0.5 * r.gravity_mps2, 1.5 * r.gravity_mps2)},
        direct=("rate_of_falls",),
        linked_direct=("rate_of_falls",),
        bounds_from_direct=True,
    ),
    export=Export(usd="physics:gravityMagnitude"),
)
