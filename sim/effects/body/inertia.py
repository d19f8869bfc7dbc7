"""Inertia factor: moments of inertia differ from the declared ones by a factor."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import ImpactCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter

_INERTIA_FACTORS = (0.3, 3.0)  # even spread of mass over shell and core


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
    free_body=TossCandidacy(
        bounds=lambda r: {"factor": _INERTIA_FACTORS}, direct=("turn_in_impacts",), linked_direct=("spin_of_link",)
    ),
    impact=ImpactCandidacy(bounds=lambda r: {"factor": _INERTIA_FACTORS}, direct="angular_balance"),
    export=Export(usd="physics:diagonalInertia", urdf="inertial/inertia", package="inertia_kgm2"),
)
