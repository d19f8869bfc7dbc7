"""A joint whose axis is not mounted as the model says: gravity pulls it to another place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from schemas.gap import Place
from sim.effects.effect import Confusable, Effect, Numbers, Parameter, Params
from sim.mechanism import MechanismModel


def _change(model: MechanismModel, params: Params, where: Place) -> MechanismModel:
    towards = params["direction_rad"]
    hinge = np.array([np.cos(towards), np.sin(towards), 0.0])
    tilted = Rotation.from_rotvec(params["angle_rad"] * hinge).apply(model.gravity_W)
    return replace(model, gravity_W=tilted)


EFFECT = Effect(
    name="joint.axis_tilt",
    kinds=("mechanism", "tracking"),
    formula="gravity in the base frame turned by angle_rad about the horizontal direction at direction_rad",
    source="statics",
    reveals="a door swings by itself; a pendulum rests off its zero or swings slower",
    parameters=(
        Parameter("angle_rad", "rad", 0.0, 1.5, 0.0),
        Parameter("direction_rad", "rad", -np.pi, np.pi, 0.0),
    ),
    confusables=(
        Confusable("actuator.bias", "switch the drive off"),
        Confusable("sensor.bias", "compare the reading at rest with a level"),
        Confusable("joint.gravity_load", "weigh the load; tilt lowers the pull, and moves the place of rest"),
    ),
    hook=Numbers(_change),
)
