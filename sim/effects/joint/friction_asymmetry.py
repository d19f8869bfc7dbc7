"""Friction asymmetry: dry friction (N m, N) that differs between the two directions."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointFriction, JointState, Params
from sim.effects.candidacy import Bounds, MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter
from sim.effects.ranges import JointRanges


def _limit(state: JointState, params: Params, direction: FloatArray) -> FloatArray:
    """No direction can have less than no friction, so the difference is at most the friction that is there."""
    most = np.inf if state.friction is None else state.friction
    return np.clip(params["torque_Nm"], -most, most) * direction


def _bounds(r: JointRanges) -> Bounds:
    most = r.friction if r.friction > 0.0 else r.torque
    return {"torque_Nm": (-most, most)}


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
    hook=JointFriction(_limit),
    mechanism=MechanismCandidacy(bounds=_bounds),
)
