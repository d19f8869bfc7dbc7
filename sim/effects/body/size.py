"""Size factor: the body's collision shapes are larger or smaller than those of the model."""

from __future__ import annotations

from dataclasses import replace

from geom.convex.scaling import scaled
from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    factor = params["factor"]
    shapes = tuple(scaled(shape, factor) for shape in model.shapes)
    return replace(model, shapes=shapes)


EFFECT = Effect(
    name="body.size",
    kinds=("free_body",),
    formula="collision shapes times factor; mass and inertia unchanged",
    source="measuring with a caliper",
    reveals="contacts happen too high or too low; the rest height is off",
    parameters=(Parameter("factor", "1", 0.5, 2.0, 1.0),),
    confusables=(
        Confusable("sensor.scale", "measure a fall: scale changes g, size does not"),
        Confusable("contact.compliance", "rest without motion"),
    ),
    hook=ModelChange(_change),
)
