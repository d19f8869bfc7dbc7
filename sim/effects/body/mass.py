"""Mass (kg) that differs from the declared one; inertia changes in proportion."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import PushCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter

_LIGHTEST, _HEAVIEST = 0.2, 5.0  # over the declared mass


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
    # A passive body shows its mass only through forces that do not scale with it; links show it to one another, but for
    # the scale of all masses: that of the base is believed.
    free_body=TossCandidacy(
        observable=lambda r: r.linked and not r.base,
        null=lambda r: {"mass_kg": r.body.mass_kg},
        bounds=lambda r: {"mass_kg": (_LIGHTEST * r.body.mass_kg, _HEAVIEST * r.body.mass_kg)},
        linked_direct=("mass_of_link",),
    ),
    push=PushCandidacy(
        observable=lambda r: r.has_force,
        null=lambda r: {"mass_kg": r.body.mass_kg},
        bounds=lambda r: {"mass_kg": (_LIGHTEST * r.body.mass_kg, _HEAVIEST * r.body.mass_kg)},
        direct="mass",
    ),
    export=Export(usd="physics:mass", urdf="inertial/mass", package="mass_kg"),
)
