"""Load-dependent friction: dry friction in proportion to the force that the bearing transmits."""

from __future__ import annotations

from schemas.arrays import FloatArray
from sim.dynamics.hooks import JointFriction, JointState, Params
from sim.effects.candidacy import MechanismCandidacy
from sim.effects.effect import Confusable, Effect, Parameter


def _limit(state: JointState, params: Params, direction: FloatArray) -> FloatArray:
    return params["radius_m"] * state.load


EFFECT = Effect(
    name="joint.load_dependent_friction",
    kinds=("mechanism", "tracking"),
    formula="dry friction radius_m * |bearing force|; radius_m = friction coefficient times bearing radius",
    source="Coulomb 1785; for servo gears Duclusaud et al., ICRA 2025, arXiv 2410.08650",
    reveals="unexplained torque grows with the load at equal speed",
    parameters=(Parameter("radius_m", "m (1 for sliding joints)", 0.0, 1.0, 0.0),),
    confusables=(Confusable("joint.coulomb_friction", "move with two different loads on the joint"),),
    hook=JointFriction(_limit, by_load=True),
    mechanism=MechanismCandidacy(
        observable=lambda r: r.any_feels_gravity, bounds=lambda r: {"radius_m": (0.0, r.torque / r.load)}
    ),
)
