"""Size factor: the body's collision shapes are larger or smaller than those of the model."""

from __future__ import annotations

from dataclasses import replace

from geom.convex.scaling import scaled
from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter

_SIZE_FACTORS = (0.7, 1.4)


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
    free_body=TossCandidacy(
        observable=lambda r: r.body.has_support,
        bounds=lambda r: {"factor": _SIZE_FACTORS},
        acts_on="linkage",
        direct=("height_at_rest",),
        bounds_from_direct=True,
    ),
    export=Export(left_out="the shape itself is wrong: scale the source and ingest it again"),
)
