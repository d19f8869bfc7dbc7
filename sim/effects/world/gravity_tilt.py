"""Gravity tilt: the support or the camera frame is not level (rad)."""

from __future__ import annotations

from dataclasses import replace

from scipy.spatial.transform import Rotation

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    turn = Rotation.from_rotvec([params["about_x_rad"], params["about_y_rad"], 0.0])
    return replace(model, gravity_W=turn.apply(model.gravity_W))


EFFECT = Effect(
    name="world.gravity_tilt",
    kinds=("free_body",),
    formula="gravity turned by about_x_rad and about_y_rad in the world frame",
    source="statics",
    reveals="free fall drifts sideways; sliding prefers one direction of the world",
    parameters=(
        Parameter("about_x_rad", "rad", -0.5, 0.5, 0.0),
        Parameter("about_y_rad", "rad", -0.5, 0.5, 0.0),
    ),
    confusables=(
        Confusable("contact.anisotropic_friction", "turn the body by a quarter"),
        Confusable("world.constant_force", "change the mass"),
    ),
    hook=ModelChange(_change),
    free_body=TossCandidacy(direct=("drift_of_falls",), linked_direct=("drift_of_falls",)),
    export=Export(usd="physics:gravityDirection"),
)
