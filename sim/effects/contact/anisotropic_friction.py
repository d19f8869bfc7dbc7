"""Anisotropic friction: sliding friction depends on the direction in the body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import PushCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Parameter


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    ratio = np.array([params["ratio"], 1.0, 1.0])
    return replace(model, friction_ratio_B=ratio)


EFFECT = Effect(
    name="contact.anisotropic_friction",
    kinds=("free_body", "push"),
    formula="friction along the body's x axis = ratio * friction along the others",
    source="Zmitrowicz, Int. J. Solids Struct. 25, 1989",
    reveals="sliding turns towards one direction of the body",
    parameters=(Parameter("ratio", "1", 0.1, 10.0, 1.0),),
    confusables=(
        Confusable("world.gravity_tilt", "turn the body by a quarter: tilt stays, anisotropy turns along"),
        Confusable("contact.friction", "slide along several directions of the body"),
    ),
    hook=ModelChange(_change),
    # Along an axis of which link? A single body answers that, a linkage does not.
    free_body=TossCandidacy(
        observable=lambda r: r.body.has_support and not r.linked,
        null=lambda r: {"ratio": float(r.body.friction_ratio_B[0])},
        bounds=lambda r: {"ratio": (0.1, 5.0)},
        direct=("turn_of_slides",),
    ),
    push=PushCandidacy(
        null=lambda r: {"ratio": float(r.body.friction_ratio_B[0])},
        bounds=lambda r: {"ratio": (0.25, 4.0)},
        direct="move_across_force",
    ),
)
