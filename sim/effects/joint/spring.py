"""Joint spring: a torque in proportion to the distance (rad, m) from a rest position."""

from __future__ import annotations

from typing import Any

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Confusable, Effect, JointState, JointTorque, Parameter


def _torque(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    stiffness_Nm_per_rad, rest_rad = values[0], values[1]
    return -stiffness_Nm_per_rad * (state.q - rest_rad)


EFFECT = Effect(
    name="joint.spring",
    kinds=("mechanism", "free_body", "tracking"),
    formula="tau = -stiffness_Nm_per_rad * (q - rest_rad)",
    source="R. Hooke, De potentia restitutiva, 1678",
    reveals="unexplained torque is a straight line over position",
    parameters=(
        Parameter("stiffness_Nm_per_rad", "N m/rad (N/m)", 0.0, 1e5, 0.0),
        Parameter("rest_rad", "rad (m)", -10.0, 10.0, 0.0),
    ),
    confusables=(
        Confusable("joint.gravity_load", "move through a quarter turn or more: a spring is straight, gravity a sine"),
        Confusable("actuator.gain", "let the joint swing with the drive off"),
    ),
    hook=JointTorque(_torque, ("stiffness_Nm_per_rad", "rest_rad")),
)
