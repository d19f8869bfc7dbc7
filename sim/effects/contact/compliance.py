"""Contact compliance: the contact yields as a spring (N/m) and a damper (N s/m)."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, stiffness_Npm=params["stiffness_Npm"], damping_Nspm=params["damping_Nspm"])


EFFECT = Effect(
    name="contact.compliance",
    kinds=("free_body",),
    formula="normal force = stiffness_Npm * depth + damping_Nspm * rate of depth",
    source="Kelvin and Voigt; Hunt and Crossley, J. Appl. Mech. 42, 1975, for spheres",
    reveals="contacts last several frames; the body sinks in",
    parameters=(
        Parameter("stiffness_Npm", "N/m", 10.0, 1e7, 1e7),
        Parameter("damping_Nspm", "N s/m", 0.0, 1e4, 10.0),
    ),
    confusables=(
        Confusable("contact.restitution", "drop from several heights"),
        Confusable("body.size", "rest without motion: size shifts the height, compliance little"),
    ),
    hook=ModelChange(_change),
    usd="physxMaterial:compliantContactStiffness",
    urdf="contact/stiffness",
)
