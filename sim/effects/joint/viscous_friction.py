"""Viscous friction: joint friction in proportion to speed."""

from __future__ import annotations

from dataclasses import replace

from schemas.gap import Place
from sim.dynamics.hooks import Confusable, Effect, ModelChange, Parameter, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.common.joint_values import with_joint_value


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
    usd="physxLimit:damping / drive:angular:physics:damping",
    urdf="dynamics/@damping",
)
