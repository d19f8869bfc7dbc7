"""PD gains: the position controller of a drive acts with other gains than declared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import ModelChange, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.candidacy import Bounds, MechanismCandidacy
from sim.effects.common.joint_values import with_joint_value
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import JointRanges

_LOWEST_GAIN, _HIGHEST_GAIN = 0.1, 4.0  # over the declared gain
_DAMPED = 2.0  # times the root of inertia and kp: where the joint does not swing


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    drive = model.drive
    kp, kd = (with_joint_value(model, getattr(drive, name), where, params[name]) for name in ("kp", "kd"))
    return replace(model, drive=replace(drive, kp=kp, kd=kd))


def _bounds(r: JointRanges) -> Bounds:
    per_unit = max(abs(r.model.drive.effort_per_unit), 1e-12)
    damped = _DAMPED * float(np.sqrt(r.inertia * r.kp / per_unit))
    return {
        "kp": (_LOWEST_GAIN * r.kp, _HIGHEST_GAIN * r.kp),
        "kd": (0.0, _HIGHEST_GAIN * r.kd + damped),
    }


EFFECT = Effect(
    name="robot.pd_gains",
    kinds=("mechanism", "tracking"),
    formula="asked effort = effort_per_unit * (kp * (command - q) - kd * qd)",
    source="Franklin, Powell, Emami-Naeini, Feedback Control of Dynamic Systems, section 4.3",
    reveals="follows commands too stiffly or too softly; overshoots more or less than declared",
    parameters=(
        Parameter("kp", "N m/rad (N/m), over effort_per_unit", 0.0, 1e7, 0.0),
        Parameter("kd", "N m s/rad (N s/m), over effort_per_unit", 0.0, 1e6, 0.0),
    ),
    confusables=(
        Confusable("joint.viscous_friction", "let the joint swing with the drive off: friction stays"),
        Confusable("actuator.gain", "send efforts past the controller, or log the effort: a gain scales all of it"),
        Confusable("joint.spring", "hold commands at several places: a spring pulls to one place"),
        Confusable("joint.armature", "hang a known load on the joint at rest: inertia does not bear it"),
        Confusable("actuator.lag", "command slow and fast tones: gains act on slow ones, too"),
    ),
    hook=ModelChange(_change),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.model.drive.type == "position_pd" and r.kp > 0.0,
        null=lambda r: {"kp": r.kp, "kd": r.kd},
        bounds=_bounds,
    ),
    plot_against="input",
    export=Export(usd="drive:angular:physics:stiffness, drive:angular:physics:damping"),
)
