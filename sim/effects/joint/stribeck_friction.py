"""Stribeck friction: dry friction that is greater at rest than in motion."""

from __future__ import annotations

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointFriction, JointState, Params
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter

_FASTER = 300.0  # the speed that was reached over the slowest law
_TYPICAL = 0.1  # of the speed that was reached


def _limit(state: JointState, params: Params, direction: FloatArray) -> FloatArray:
    return params["torque_Nm"] * np.exp(-((state.qd / params["velocity_radps"]) ** 2))


EFFECT = Effect(
    name="joint.stribeck_friction",
    kinds=("mechanism", "tracking"),
    formula="extra dry friction torque_Nm * exp(-(qd / velocity_radps)^2)",
    source="R. Stribeck, Z. VDI 46, 1902; form of Bo and Pavelescu, Wear 82, 1982",
    reveals="stick-slip near rest: unexplained torque peaks as the speed passes zero and falls off beyond",
    parameters=(
        Parameter("torque_Nm", "N m (N for sliding joints)", 0.0, 1e3, 0.0),
        Parameter("velocity_radps", "rad/s (m/s)", 1e-3, 10.0, 0.1, is_shape=True),
    ),
    confusables=(
        Confusable("joint.coulomb_friction", "dwell at very low speeds in both directions"),
        Confusable("joint.detent", "stop at several positions: detents stay in place, stiction moves along"),
    ),
    hook=JointFriction(_limit),
    mechanism=MechanismCandidacy(
        bounds=lambda r: {"torque_Nm": (0.0, r.torque), "velocity_radps": (r.speed / _FASTER, r.speed)},
        start=lambda r: {"velocity_radps": _TYPICAL * r.speed},
    ),
)
