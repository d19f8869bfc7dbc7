"""Rolling friction: a moment that opposes rolling, with a lever arm (m) on the normal force."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter

_LARGEST_LEVER = 0.2  # lever over the size


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, rolling_friction_m=params["lever_m"])


EFFECT = Effect(
    name="contact.rolling_friction",
    kinds=("free_body",),
    formula="moment <= lever_m * normal force, against rolling",
    source="Coulomb 1785; Dupuit 1837",
    reveals="round bodies come to rest though nothing slides",
    parameters=(Parameter("lever_m", "m", 0.0, 0.1, 0.0),),
    confusables=(
        Confusable("world.linear_drag", "roll at several speeds: drag grows with speed"),
        Confusable("contact.spinning_friction", "roll without spin"),
    ),
    hook=ModelChange(_change),
    free_body=TossCandidacy(
        observable=lambda r: r.body.has_support,
        null=lambda r: {"lever_m": r.body.rolling_friction_m},
        bounds=lambda r: {"lever_m": (0.0, _LARGEST_LEVER * r.size_m)},
    ),
    export=Export(urdf="contact/rolling_friction", urdf_contact={"lever_m": "rolling_friction"}),
)
