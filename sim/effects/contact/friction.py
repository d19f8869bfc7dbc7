"""Sliding friction of the pair body and support (Coulomb coefficient)."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, friction=params["mu"])


EFFECT = Effect(
    name="contact.friction",
    kinds=("free_body", "impact", "push"),
    formula="|tangential force| <= mu * normal force",
    source="Coulomb 1785; Amontons 1699",
    reveals="sliding stops earlier or later than simulated; impacts turn the body differently",
    parameters=(Parameter("mu", "1", 0.0, 2.0, 0.5),),
    confusables=(
        Confusable("contact.restitution", "slide without bouncing; bounce without sliding"),
        Confusable("world.gravity_tilt", "slide in opposite directions"),
        Confusable("contact.anisotropic_friction", "slide along several directions of the body"),
    ),
    hook=ModelChange(_change),
    usd="physics:dynamicFriction, physics:staticFriction",
    urdf="contact/lateral_friction",
)
