"""Viscous friction: joint friction in proportion to speed."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import ModelChange, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.candidacy import Bounds, MechanismCandidacy, TossCandidacy, within
from sim.effects.common.joint_values import with_joint_value
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import TOLERANCE, JointRanges

_FASTEST_S = 0.02  # joint damping may stop a link within this
_STEADIEST = 0.3  # of inertia over a step: what drives harder would throw a joint out within a few steps


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    return replace(model, damping=with_joint_value(model, model.damping, where, params["damping_Nms_per_rad"]))


def _bounds(r: JointRanges) -> Bounds:
    """A joint alone only loses energy; a drive whose rate is late or whose gains are others gives it some."""
    strongest = r.torque / r.speed
    least = -min(strongest, _STEADIEST * r.inertia / r.step_s) if r.driven else 0.0
    return {"damping_Nms_per_rad": (least, strongest + 2.0 * r.damping)}


EFFECT = Effect(
    name="joint.viscous_friction",
    kinds=("mechanism", "free_body", "tracking"),
    formula="tau = -damping_Nms_per_rad * qd",
    source="I. Newton, Principia, book II, section IX; grease and back-EMF act alike",
    reveals="amplitude decays by a constant factor per swing; it grows below zero, which only a drive can do",
    parameters=(Parameter("damping_Nms_per_rad", "N m s/rad (N s/m for sliding joints)", -1e4, 1e4, 0.0),),
    confusables=(
        Confusable("joint.coulomb_friction", "move at speeds that differ by a factor of three or more"),
        Confusable("joint.quadratic_drag", "move at speeds that differ by a factor of three or more"),
        Confusable("actuator.gain", "let the joint swing with the drive off"),
        Confusable("robot.pd_gains", "let the joint swing with the drive off: friction stays"),
    ),
    hook=ModelChange(_change),
    mechanism=MechanismCandidacy(
        null=lambda r: {"damping_Nms_per_rad": r.damping},
        bounds=_bounds,
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
        urdf_least=0.0,
    ),
)
