"""Mass centre offset: the mass centre lies elsewhere (m, body frame) than in the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, com_B=np.array([params["x_m"], params["y_m"], params["z_m"]]))


EFFECT = Effect(
    name="body.com_offset",
    kinds=("free_body", "impact", "push"),
    formula="mass centre at (x_m, y_m, z_m) in the body frame",
    source="rigid-body mechanics",
    reveals="in flight the measured origin wobbles about a point that falls straight",
    parameters=(
        Parameter("x_m", "m", -1.0, 1.0, 0.0),
        Parameter("y_m", "m", -1.0, 1.0, 0.0),
        Parameter("z_m", "m", -1.0, 1.0, 0.0),
    ),
    confusables=(
        Confusable("body.inertia", "toss it spinning about several axes"),
        Confusable("contact.anisotropic_friction", "look at the free flight: only the mass centre shows there"),
    ),
    hook=ModelChange(_change),
    usd="physics:centerOfMass",
    urdf="inertial/origin",
)
