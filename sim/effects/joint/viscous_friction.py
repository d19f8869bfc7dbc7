"""Viscous friction: joint friction in proportion to speed."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.hooks import ModelChange, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.candidacy import MechanismCandidacy, TossCandidacy, within
from sim.effects.common.joint_values import with_joint_value
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import TOLERANCE

_FASTEST_S = 0.02  # joint damping may stop a link within this


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    return replace(model, damping=with_joint_value(model, model.damping, where, params["damping_Nms_per_rad"]))


EFFECT = Effect(
    name="joint.viscous_friction",
    kinds=("mechanism", "free_body", "tracking"),
    formula="tau = -damping_Nms_per_rad * qd",
    source="I. Newton, Principia, book II, section IX; grease and back-EMF act alike",
    reveals="amplitude decays by a constant factor per swing",
    parameters=(Parameter("damping_Nms_per_rad", "N m s/rad (N s/m for sliding joints)", 0.0, 1e4, 0.0),),
    confusables=(
        Confusable("joint.coulomb_friction", "move at speeds that differ by a factor of three or more"),
        Confusable("joint.quadratic_drag", "move at speeds that differ by a factor of three or more"),
        Confusable("actuator.gain", "let the joint swing with the drive off"),
    ),
    hook=ModelChange(_change),
    mechanism=MechanismCandidacy(
        null=lambda r: {"damping_Nms_per_rad": r.damping},
        bounds=lambda r: {"damping_Nms_per_rad": (0.0, r.torque / r.speed + 2.0 * r.damping)},
        nuisance=lambda joint: within("damping", "damping_Nms_per_rad", joint.damping, TOLERANCE * joint.damping),
    ),
    free_body=TossCandidacy(
        observable=lambda r: r.joint is not None,
        null=lambda r: {"damping_Nms_per_rad": r.joint.declared.damping} if r.joint else {},
        bounds=lambda r: (
            {"damping_Nms_per_rad": (0.0, r.joint.declared.inertia_at_zero / _FASTEST_S)} if r.joint else {}
        ),
        linked_direct=("viscous_effort",),
    ),
    export=Export(
        usd="physxLimit:damping / drive:angular:physics:damping",
        urdf="dynamics/@damping",
        urdf_joint={"damping_Nms_per_rad": "damping"},
    ),
)
