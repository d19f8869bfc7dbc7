"""Stribeck friction: dry friction that is greater at rest than in motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointFriction, JointState
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter, Scan

_FASTER = 300.0  # the speed that was reached over the slowest law
_TYPICAL = 0.1  # of the speed that was reached
_SPEEDS = Scan(6, by_ratio=True, from_low=2.0, to_high=0.7)  # that a search probes: ends of the range say nothing


def _limit(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    torque_Nm, velocity_radps = values[0], values[1]
    return torque_Nm * np.exp(-((state.qd / velocity_radps) ** 2))


EFFECT = Effect(
    name="joint.stribeck_friction",
    kinds=("mechanism", "tracking"),
    formula="extra dry friction torque_Nm * exp(-(qd / velocity_radps)^2)",
    source="R. Stribeck, Z. VDI 46, 1902; form of Bo and Pavelescu, Wear 82, 1982",
    reveals="stick-slip near rest: unexplained torque peaks as the speed passes zero and falls off beyond",
    parameters=(
        Parameter("torque_Nm", "N m (N for sliding joints)", 0.0, 1e3, 0.0),
        Parameter("velocity_radps", "rad/s (m/s)", 1e-3, 10.0, 0.1, is_shape=True, scan=_SPEEDS),
    ),
    confusables=(
        Confusable("joint.coulomb_friction", "dwell at very low speeds in both directions"),
        Confusable("joint.detent", "stop at several positions: detents stay in place, stiction moves along"),
    ),
    hook=JointFriction(_limit, ("torque_Nm", "velocity_radps")),
    mechanism=MechanismCandidacy(
        bounds=lambda r: {"torque_Nm": (0.0, r.torque), "velocity_radps": (r.speed / _FASTER, r.speed)},
        start=lambda r: {"velocity_radps": _TYPICAL * r.speed},
    ),
)
