"""Spinning friction: a moment that opposes turning about the contact normal, with a lever arm (m)."""

from __future__ import annotations

from dataclasses import replace

from schemas.sim_gap.extension import Place
from sim.dynamics.body_rollout import BodyModel
from sim.dynamics.hooks import ModelChange, Params
from sim.effects.candidacy import Bounds, Nuisance, PushCandidacy, TossCandidacy
from sim.effects.effect import Confusable, Effect, Export, Parameter
from sim.effects.ranges import PushRanges

_LARGEST_LEVER = 0.2  # lever over the size
_SHORTEST, _LONGEST = 0.2, 3.0  # over the lever under an even pressure
# Share within which an even pressure is believed: it is assumed, and no limit surface is an ellipsoid.
_PRESSURE = 0.15


def _change(model: BodyModel, params: Params, where: Place) -> BodyModel:
    return replace(model, spinning_friction_m=params["lever_m"])


def _even_lever(r: PushRanges) -> float:
    return r.reference_friction * r.lever_m


def _push_bounds(r: PushRanges) -> Bounds:
    return {"lever_m": (_SHORTEST * _even_lever(r), _LONGEST * _even_lever(r))}


def _even_pressure(r: PushRanges) -> Nuisance:
    lever = _even_lever(r)
    return Nuisance("friction", "lever_m", lever, (1.0 - _PRESSURE) * lever, (1.0 + _PRESSURE) * lever)


EFFECT = Effect(
    name="contact.spinning_friction",
    kinds=("free_body", "push"),
    formula="moment <= lever_m * normal force, about the normal",
    source="Contensou 1963",
    reveals="a body that spins in place comes to rest",
    parameters=(Parameter("lever_m", "m", 0.0, 0.1, 0.0),),
    confusables=(
        Confusable("contact.friction", "spin in place: point contacts have no lever"),
        Confusable("contact.rolling_friction", "spin without rolling"),
    ),
    hook=ModelChange(_change),
    free_body=TossCandidacy(
        observable=lambda r: r.body.has_support,
        null=lambda r: {"lever_m": r.body.spinning_friction_m},
        bounds=lambda r: {"lever_m": (0.0, _LARGEST_LEVER * r.size_m)},
    ),
    # What resists spinning follows from the pressure under the body, which is only assumed to be even.
    push=PushCandidacy(
        null=lambda r: {"lever_m": _even_lever(r)},
        bounds=_push_bounds,
        nuisance=_even_pressure,
        direct="turn_over_slide",
    ),
    export=Export(urdf="contact/spinning_friction", urdf_contact={"lever_m": "spinning_friction"}),
)
