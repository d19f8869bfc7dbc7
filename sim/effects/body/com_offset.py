"""Mass centre offset: the mass centre lies elsewhere (m, body frame) than in the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import Bounds, ImpactCandidacy, PushCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import ImpactRanges, PushRanges, TossRanges, declared_com

_FIXED_M = 1e-12  # an axis that planar motion does not show


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, com_B=np.array([params["x_m"], params["y_m"], params["z_m"]]))


def _within_a_third(r: TossRanges) -> Bounds:
    return {n: (v - r.size_m / 3.0, v + r.size_m / 3.0) for n, v in declared_com(r.body).items()}


def _within_gyration(r: ImpactRanges) -> Bounds:
    """As far as a homogeneous body's mass centre can be from where its inertia says it is."""
    com, reach = declared_com(r.body), float(np.sqrt(r.body.inertia_B[2, 2] / r.body.mass_kg))
    return {n: (v - reach, v + reach) for n, v in com.items()} | {"z_m": (com["z_m"], com["z_m"] + _FIXED_M)}


def _within_foot(r: PushRanges) -> Bounds:
    height = declared_com(r.body)["z_m"]
    sides = {n: (float(r.low_m[k]), float(r.high_m[k])) for k, n in enumerate(("x_m", "y_m"))}
    return sides | {"z_m": (height, height + _FIXED_M)}


EFFECT = Effect(
    name="body.com_offset",
    kinds=("free_body", "impact", "push"),
    formula="mass centre at (x_m, y_m, z_m) in the body frame",
    source="rigid-body mechanics",
    reveals="in flight the measured origin wobbles about a point that falls straight",
    parameters=(
        Parameter("x_m", "m", -1.0, 1.0, 0.0),
        Parameter("y_m", "m", -1.0, 1.0, 0.0),
        Parameter("z_m", "m", -1.0, 1.0, 0.0),
    ),
    confusables=(
        Confusable("body.inertia", "toss it spinning about several axes"),
        Confusable("contact.anisotropic_friction", "look at the free flight: only the mass centre shows there"),
    ),
    hook=ModelChange(_change),
    free_body=TossCandidacy(
        null=lambda r: declared_com(r.body),
        bounds=_within_a_third,
        direct=("wobble_in_flight",),
        linked_direct=("wobble_of_link",),
    ),
    impact=ImpactCandidacy(
        observable=lambda r: r.has_pose,
        null=lambda r: declared_com(r.body),
        bounds=_within_gyration,
        direct="mass_centre",
    ),
    push=PushCandidacy(null=lambda r: declared_com(r.body), bounds=_within_foot, direct="mass_centre"),
    export=Export(usd="physics:centerOfMass", urdf="inertial/origin", package="centre_of_mass_m"),
)
