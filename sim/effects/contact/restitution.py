"""Restitution of the pair body and support: ratio of normal speeds after and before an impact."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import ImpactCandidacy, Nuisance, TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import TOLERANCE

_LARGEST_BOUNCE = 1.5


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, restitution=params["restitution"])


def _known(body: BodyModel) -> Nuisance:
    value = body.restitution
    return Nuisance(
        "bounce", "restitution", value, max(0.0, value - TOLERANCE), min(_LARGEST_BOUNCE, value + TOLERANCE)
    )


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
    free_body=TossCandidacy(
        observable=lambda r: r.body.has_support,
        null=lambda r: {"restitution": r.body.restitution},
        nuisance=lambda body: _known(body) if body.has_support else None,
        direct=("speeds_about_impacts",),
    ),
    impact=ImpactCandidacy(
        null=lambda r: {"restitution": r.body.restitution}, nuisance=_known, direct="parting_over_approach"
    ),
    export=Export(usd="physics:restitution", urdf="contact/restitution", package="restitution"),
)
