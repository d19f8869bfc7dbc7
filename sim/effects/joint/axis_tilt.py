"""Axis tilt: the joint's axis is mounted at an angle (rad) to that of the model, which changes the pull of gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.sim_gap.extension import Place
from sim.dynamics.hooks import ModelChange, Params
from sim.dynamics.mechanism import MechanismModel
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    # Two angles instead of one and its direction: at no tilt every direction is the same, and no search can begin.
    turn = np.array([params["about_x_rad"], params["about_y_rad"], 0.0])
    return replace(model, gravity_W=Rotation.from_rotvec(turn).apply(model.gravity_W))


EFFECT = Effect(
    name="joint.axis_tilt",
    kinds=("mechanism", "tracking"),
    formula="gravity in the base frame turned by the rotation vector (about_x_rad, about_y_rad, 0)",
    source="statics",
    reveals="a door swings by itself; a pendulum rests off its zero or swings slower",
    parameters=(
        Parameter("about_x_rad", "rad", -1.5, 1.5, 0.0),
        Parameter("about_y_rad", "rad", -1.5, 1.5, 0.0),
    ),
    confusables=(
        Confusable("actuator.bias", "switch the drive off"),
        Confusable("sensor.bias", "compare the reading at rest with a level"),
        Confusable("joint.gravity_load", "weigh the load; tilt lowers the pull, and moves the place of rest"),
    ),
    hook=ModelChange(_change),
    mechanism=MechanismCandidacy(observable=lambda r: r.any_feels_gravity, whole_log=True),
    plot_against="position",
)
