"""Hard stop: a mechanical end of travel (rad, m) that the model lacks, as a stiff spring with losses."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import Confusable, Effect, JointState, JointTorque, Parameter


def _torque(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    """More on the way in than on the way out, so that a blow loses energy; a stop never pulls."""
    lower_rad, upper_rad, stiffness_Nm_per_rad, loss_s_per_rad = values[0], values[1], values[2], values[3]
    above = np.maximum(state.q - upper_rad, 0.0) * np.maximum(1.0 + loss_s_per_rad * state.qd, 0.0)
    below = np.maximum(lower_rad - state.q, 0.0) * np.maximum(1.0 + loss_s_per_rad * -state.qd, 0.0)
    return stiffness_Nm_per_rad * (below - above)


EFFECT = Effect(
    name="joint.hard_stop",
    kinds=("mechanism",),
    formula=(
        "tau = stiffness_Nm_per_rad * (max(lower_rad - q, 0) * max(1 - loss_s_per_rad * qd, 0)"
        " - max(q - upper_rad, 0) * max(1 + loss_s_per_rad * qd, 0))"
    ),
    source="Hunt and Crossley, J. Appl. Mech. 42 (1975), with a force in proportion to the depth",
    reveals="motion turns back at the same position every time, with a short large torque",
    parameters=(
        Parameter("lower_rad", "rad (m)", -100.0, 100.0, -100.0),
        Parameter("upper_rad", "rad (m)", -100.0, 100.0, 100.0),
        Parameter("stiffness_Nm_per_rad", "N m/rad (N/m)", 1e-3, 1e6, 100.0),
        Parameter("loss_s_per_rad", "s/rad (s/m)", 0.0, 1000.0, 0.0),
    ),
    confusables=(Confusable("joint.spring", "approach the end slowly: a spring acts over the whole range"),),
    hook=JointTorque(_torque, ("lower_rad", "upper_rad", "stiffness_Nm_per_rad", "loss_s_per_rad")),
    usd="physics:lowerLimit, physics:upperLimit",
    urdf="limit/@lower, limit/@upper",
)
