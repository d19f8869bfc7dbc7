"""Joint spring: a torque in proportion to the distance (rad, m) from a rest position."""

from __future__ import annotations

from typing import Any

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointState, JointTorque
from sim.effects.candidacy import Bounds, MechanismCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Parameter, Scan
from sim.effects.ranges import TossRanges

_STIFFEST_SPRING = 4.0  # times what the torque does over the range that was reached
_LEAST_SPAN = 1e-9  # rad (m)
_FASTEST_RADPS = 60.0  # of a swing of the link by itself


def _torque(state: JointState, values: FloatArray, memory: FloatArray) -> Any:
    stiffness_Nm_per_rad, rest_rad = values[0], values[1]
    return -stiffness_Nm_per_rad * (state.q - rest_rad)


def _linked_bounds(r: TossRanges) -> Bounds:
    if r.joint is None:
        return {}
    stiffest = r.joint.declared.inertia_at_zero * _FASTEST_RADPS**2
    return {"stiffness_Nm_per_rad": (0.0, stiffest), "rest_rad": (-r.joint.half_travel, r.joint.half_travel)}


EFFECT = Effect(
    name="joint.spring",
    kinds=("mechanism", "free_body", "tracking"),
    formula="tau = -stiffness_Nm_per_rad * (q - rest_rad)",
    source="R. Hooke, De potentia restitutiva, 1678",
    reveals="unexplained torque is a straight line over position",
    parameters=(
        Parameter("stiffness_Nm_per_rad", "N m/rad (N/m)", 0.0, 1e5, 0.0),
        Parameter("rest_rad", "rad (m)", -10.0, 10.0, 0.0, is_shape=True, scan=Scan(5)),
    ),
    confusables=(
        Confusable("joint.gravity_load", "move through a quarter turn or more: a spring is straight, gravity a sine"),
        Confusable("actuator.gain", "let the joint swing with the drive off"),
    ),
    hook=JointTorque(_torque, ("stiffness_Nm_per_rad", "rest_rad")),
    mechanism=MechanismCandidacy(
        null=lambda r: {"rest_rad": 0.5 * (r.low + r.high)},
        bounds=lambda r: {
            "stiffness_Nm_per_rad": (0.0, _STIFFEST_SPRING * r.torque / max(r.span, _LEAST_SPAN)),
            "rest_rad": (r.low - r.span, r.high + r.span),
        },
    ),
    free_body=TossCandidacy(observable=lambda r: r.joint is not None, bounds=_linked_bounds),
    plot_against="position",
)
