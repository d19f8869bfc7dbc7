"""Gravity load: the moment of gravity on a link differs from the declared one by a factor."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import ModelChange, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.candidacy import MechanismCandidacy, within
from sim.effects.common.joint_values import with_link
from sim.effects.effect import Confusable, Effect, Parameter
from sim.effects.ranges import TOLERANCE


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    return with_link(model, where, lambda link: replace(link, gravity_factor=params["factor"]))


EFFECT = Effect(
    name="joint.gravity_load",
    kinds=("mechanism", "tracking"),
    formula="gravity on the link times factor; its inertia stays",
    source="statics",
    reveals="unexplained torque is the sine of the position; free swings have another frequency",
    parameters=(Parameter("factor", "1", 0.0, 10.0, 1.0),),
    confusables=(
        Confusable("joint.armature", "measure the torque that holds it at rest; a free swing shows the ratio only"),
        Confusable("joint.spring", "move through a quarter turn or more"),
        Confusable("world.gravity_magnitude", "weigh the load"),
    ),
    hook=ModelChange(_change),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.any_feels_gravity,
        nuisance=lambda joint: within("weight", "factor", 1.0, TOLERANCE if joint.feels_gravity else 0.0),
    ),
    plot_against="position",
)
