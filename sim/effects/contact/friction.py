"""Sliding friction of the pair body and support (Coulomb coefficient)."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import ImpactCandidacy, Nuisance, PushCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import PUSHER_PAIR, TOLERANCE

_LARGEST_MU = 1.5
_ENGINES = 0.15  # two engines, and sliding and impacts in one, differ by this share about the friction of a pair
_PUSHER_FRICTION = (0.02, 1.2)


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, friction=params["mu"])


def _known_to(mu: float, half: float) -> Nuisance | None:
    return Nuisance("friction", "mu", mu, max(0.0, mu - half), min(_LARGEST_MU, mu + half)) if half > 0.0 else None


EFFECT = Effect(
    name="contact.friction",
    kinds=("free_body", "impact", "push"),
    formula="|tangential force| <= mu * normal force",
    source="Coulomb 1785; Amontons 1699",
    reveals="sliding stops earlier or later than simulated; impacts turn the body differently",
    parameters=(Parameter("mu", "1", 0.0, 2.0, 0.5),),
    confusables=(
        Confusable("contact.restitution", "slide without bouncing; bounce without sliding"),
        Confusable("world.gravity_tilt", "slide in opposite directions"),
        Confusable("contact.anisotropic_friction", "slide along several directions of the body"),
    ),
    hook=ModelChange(_change),
    free_body=TossCandidacy(
        observable=lambda r: r.body.has_support,
        null=lambda r: {"mu": r.body.friction},
        bounds=lambda r: {"mu": (0.0, _LARGEST_MU)},
        nuisance=lambda body: _known_to(body.friction, _ENGINES * body.friction) if body.has_support else None,
        direct=("slowing_of_slides",),
        linked_direct=("slowing_of_slides",),
    ),
    impact=ImpactCandidacy(
        null=lambda r: {"mu": r.body.friction},
        bounds=lambda r: {"mu": (0.0, _LARGEST_MU)},
        nuisance=lambda body: _known_to(body.friction, TOLERANCE * body.friction),
        direct="sliding_impulse",
    ),
    # The pusher's friction is declared nowhere. That of the support is no nuisance: beside it, mass would be a second
    # name for one number, and neither could be doubted.
    push=PushCandidacy(
        observable=lambda r: r.has_force,
        null=lambda r: {"mu": r.body.friction},
        bounds=lambda r: {"mu": (0.0, _LARGEST_MU)},
        nuisance=lambda r: Nuisance("friction", "mu", r.pusher_friction, *_PUSHER_FRICTION, PUSHER_PAIR),
        direct="level_of_force",
    ),
    export=Export(
        usd="physics:dynamicFriction, physics:staticFriction", urdf="contact/lateral_friction", package="friction"
    ),
)
