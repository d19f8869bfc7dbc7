"""Friction asymmetry: dry friction (N m, N) that differs between the two directions."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Confusable, Effect, JointFriction, JointState, Parameter


def _limit(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    """No direction can have less than no friction, so the difference is at most the friction that is there."""
    return np.minimum(np.maximum(values[0], -state.friction), state.friction) * state.direction


EFFECT = Effect(
    name="joint.friction_asymmetry",
    kinds=("mechanism", "tracking"),
    formula="dry friction + torque_Nm in the positive direction, - torque_Nm in the negative one, each at least 0",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, section 3",
    reveals="unexplained torque has a different size in each direction",
    parameters=(Parameter("torque_Nm", "N m (N for sliding joints)", -1e3, 1e3, 0.0),),
    confusables=(
        Confusable("actuator.bias", "hold still: a bias pushes, friction does not; or let it swing with the drive off"),
        Confusable("joint.axis_tilt", "move over the whole range: gravity depends on position, friction does not"),
    ),
    hook=JointFriction(_limit, ("torque_Nm",)),
)
