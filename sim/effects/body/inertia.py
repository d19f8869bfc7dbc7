"""Inertia factor: moments of inertia differ from the declared ones by a factor."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, inertia_B=model.inertia_B * params["factor"])


EFFECT = Effect(
    name="body.inertia",
    kinds=("free_body", "impact"),
    formula="inertia = factor * declared, mass unchanged",
    source="rigid-body mechanics",
    reveals="off-centre impacts turn the body too fast or too slow",
    parameters=(Parameter("factor", "1", 0.1, 10.0, 1.0),),
    confusables=(
        Confusable("contact.restitution", "drop flat and on a corner"),
        Confusable("contact.friction", "toss it spinning: free rotation shows ratios of the moments"),
    ),
    hook=ModelChange(_change),
    usd="physics:diagonalInertia",
    urdf="inertial/inertia",
)
