"""Restitution of the pair body and support: ratio of normal speeds after and before an impact."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, restitution=params["restitution"])


EFFECT = Effect(
    name="contact.restitution",
    kinds=("free_body", "impact"),
    formula="normal speed after impact = -restitution * normal speed before",
    source="I. Newton, Principia, 1687",
    reveals="height and speed after impacts",
    parameters=(Parameter("restitution", "1", 0.0, 1.0, 0.0),),
    confusables=(
        Confusable("contact.compliance", "drop from several heights: compliance also changes how long contact lasts"),
        Confusable("body.inertia", "drop flat and on a corner: inertia matters off-centre only"),
    ),
    hook=ModelChange(_change),
    usd="physics:restitution",
    urdf="contact/restitution",
)
