"""Dry (Coulomb) friction of a joint (N m, N), independent of speed."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import ModelChange, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.candidacy import MechanismCandidacy, TossCandidacy, within
from sim.effects.common.joint_values import with_joint_value
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import TOLERANCE

_LARGEST_MOMENT = 0.3  # of the weight at the reach of a link


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    return replace(model, friction=with_joint_value(model, model.friction, where, params["torque_Nm"]))


EFFECT = Effect(
    name="joint.coulomb_friction",
    kinds=("mechanism", "free_body", "tracking"),
    formula="tau = -torque_Nm * sign(qd); at rest any value up to torque_Nm",
    source="C. A. Coulomb, Theorie des machines simples, 1785",
    reveals="equal loss of amplitude per swing; rest away from equilibrium; a step in torque at reversal",
    parameters=(Parameter("torque_Nm", "N m (N for sliding joints)", 0.0, 1e3, 0.0),),
    confusables=(
        Confusable("joint.viscous_friction", "move at speeds that differ by a factor of three or more"),
        Confusable("joint.load_dependent_friction", "move with two different loads on the joint"),
        Confusable("actuator.deadband", "let the joint swing with the drive off"),
    ),
    hook=ModelChange(_change),
    mechanism=MechanismCandidacy(
        null=lambda r: {"torque_Nm": r.friction},
        bounds=lambda r: {"torque_Nm": (0.0, r.torque + r.friction)},
        nuisance=lambda joint: within("friction", "torque_Nm", joint.friction, TOLERANCE * joint.friction),
    ),
    free_body=TossCandidacy(
        observable=lambda r: r.joint is not None,
        null=lambda r: {"torque_Nm": r.joint.declared.friction} if r.joint else {},
        bounds=lambda r: {"torque_Nm": (0.0, _LARGEST_MOMENT * r.joint.weight_N * r.joint.reach_m)} if r.joint else {},
        linked_direct=("dry_effort",),
    ),
    export=Export(usd="physxJoint:jointFriction", urdf="dynamics/@friction", urdf_joint={"torque_Nm": "friction"}),
)
