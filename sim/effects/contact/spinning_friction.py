"""Spinning friction: a moment that opposes turning about the contact normal, with a lever arm (m)."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, spinning_friction_m=params["lever_m"])


EFFECT = Effect(
    name="contact.spinning_friction",
    kinds=("free_body", "push"),
    formula="moment <= lever_m * normal force, about the normal",
    source="Contensou 1963",
    reveals="a body that spins in place comes to rest",
    parameters=(Parameter("lever_m", "m", 0.0, 0.1, 0.0),),
    confusables=(
        Confusable("contact.friction", "spin in place: point contacts have no lever"),
        Confusable("contact.rolling_friction", "spin without rolling"),
    ),
    hook=ModelChange(_change),
    urdf="contact/spinning_friction",
)
