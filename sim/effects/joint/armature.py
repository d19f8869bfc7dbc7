"""Armature: inertia (kg m2, kg) of rotor and gears that acts at the joint."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import ModelChange, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.candidacy import MechanismCandidacy, within
from sim.effects.common.joint_values import with_link
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import TOLERANCE

_LEAST, _MOST = -0.8, 4.0  # of the declared inertia about the joint


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    return with_link(model, where, lambda link: replace(link, armature=params["inertia_kgm2"]))


EFFECT = Effect(
    name="joint.armature",
    kinds=("mechanism", "tracking"),
    formula="tau = inertia_kgm2 * qdd in addition to the links' own; negative: the declared inertia is too great",
    source="Featherstone, Rigid Body Dynamics Algorithms, 2008, section 9.6",
    reveals="unexplained torque in proportion to acceleration; free swings are slower than modelled",
    parameters=(Parameter("inertia_kgm2", "kg m2 (kg for sliding joints)", -1e3, 1e3, 0.0),),
    confusables=(
        Confusable("actuator.lag", "accelerate at several frequencies: a lag delays, inertia does not"),
        Confusable("joint.gravity_load", "move with the axis turned upright, so that gravity has no lever"),
        Confusable("actuator.gain", "hang a known load on the joint"),
    ),
    hook=ModelChange(_change),
    mechanism=MechanismCandidacy(
        bounds=lambda r: {"inertia_kgm2": (_LEAST * r.inertia, _MOST * r.inertia)},
        nuisance=lambda joint: within("inertia", "inertia_kgm2", 0.0, TOLERANCE * joint.inertia_at_zero),
    ),
    export=Export(usd="physxJoint:armature"),
)
