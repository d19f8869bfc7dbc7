"""Mass (kg) that differs from the declared one; inertia changes in proportion."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    factor = params["mass_kg"] / model.mass_kg
    return replace(model, mass_kg=params["mass_kg"], inertia_B=model.inertia_B * factor)


EFFECT = Effect(
    name="body.mass",
    kinds=("free_body", "push"),
    formula="mass_kg; inertia in proportion",
    source="weighing",
    reveals="needs a known force: passive motion under gravity does not show mass",
    parameters=(Parameter("mass_kg", "kg", 1e-6, 1e5, 1.0),),
    confusables=(
        Confusable("contact.friction", "weigh the body"),
        Confusable("world.quadratic_drag", "weigh the body"),
        Confusable("world.constant_force", "weigh the body"),
    ),
    hook=ModelChange(_change),
    usd="physics:mass",
    urdf="inertial/mass",
)
