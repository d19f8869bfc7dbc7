"""Replaces derived values in the physics section of a record by measured ones, and updates the values that follow."""

from __future__ import annotations

from typing import Any

import numpy as np

from assetkit.mass.estimate import UNIFORMITY
from schemas.asset import MassPart, PhysicsSection
from schemas.evidence import Evidence
from schemas.measured_physics import MeasuredPhysics
from schemas.physics import Contact


def extended_section(section: PhysicsSection, measured: MeasuredPhysics) -> PhysicsSection:
    """`section` with the measured values; values that follow from them are updated.

    A measured mass scales densities and, unless it was measured too, inertia. A measured friction is that of one pair:
    both coefficients take it, the rule becomes `minimum` (exact on any support that is no smoother), and records of
    the material class against other counterparts, which it contradicts, are dropped. Parts of several materials all
    take it: which of them was in contact is unknown.
    """
    changed: dict[str, Any] = {}
    if measured.mass_kg is not None:
        mass, factor = measured.mass_kg, measured.mass_kg.value / section.mass_kg.value
        changed["mass_kg"] = mass
        changed["density_kgm3"] = _in_proportion(section.density_kgm3, factor, mass)
        changed["mass_parts"] = tuple(_denser(part, factor, mass) for part in section.mass_parts)
        changed["inertia_kgm2"] = _in_proportion(section.inertia_kgm2, factor, mass, UNIFORMITY)
    if measured.inertia_kgm2 is not None:
        changed["inertia_kgm2"] = measured.inertia_kgm2
    if measured.centre_of_mass_m is not None:
        changed["centre_of_mass_m"] = measured.centre_of_mass_m
    if measured.friction is not None or measured.restitution is not None:
        changed["contacts"] = _contacts(section.contacts, measured)
        parts = changed.get("mass_parts", section.mass_parts)
        changed["mass_parts"] = tuple(
            part.model_copy(update={"contacts": changed["contacts"]}) if part.contacts else part for part in parts
        )
    return section.model_copy(update=changed)


def _contacts(contacts: tuple[Evidence[Contact], ...], measured: MeasuredPhysics) -> tuple[Evidence[Contact], ...]:
    general = contacts[0]
    value, methods = general.value, []
    low, high = general.bounds or (value, value)
    if (friction := measured.friction) is not None:
        methods.append(friction.method)
        value = _with_friction(value, friction.value).model_copy(update={"combine": "minimum"})
        least, most = friction.bounds or (friction.value, friction.value)
        low, high = _with_friction(low, least), _with_friction(high, most)
    if (restitution := measured.restitution) is not None:
        methods.append(restitution.method)
        least, most = restitution.bounds or (restitution.value, restitution.value)
        value, low, high = (
            contact.model_copy(update={"restitution": e})
            for contact, e in ((value, restitution.value), (low, least), (high, most))
        )
    unmeasured = [n for n in ("friction", "restitution") if getattr(measured, n) is None]
    confidence = min(e.confidence for e in (friction, restitution) if e is not None)
    evidence = Evidence[Contact](
        value=value,
        source="measured",
        method="; ".join([*methods, *(f"{n} as before: {general.method}" for n in unmeasured)]),
        confidence=min([confidence, *(general.confidence for _ in unmeasured)]),
        bounds=(low, high),
        inputs=general.inputs if unmeasured else (),
    )
    return (evidence,) if friction is not None else (evidence, *contacts[1:])


def _with_friction(contact: Contact, mu: float) -> Contact:
    return contact.model_copy(update={"static_friction": mu, "dynamic_friction": mu})


def _denser(part: MassPart, factor: float, mass: Evidence[float]) -> MassPart:
    return part.model_copy(update={"density_kgm3": _in_proportion(part.density_kgm3, factor, mass)})


def _in_proportion(evidence: Evidence[Any], factor: float, mass: Evidence[float], trust: float = 1.0) -> Evidence[Any]:
    """`evidence` times `factor`, with the confidence of the measured mass that it now follows from (times `trust`)."""

    def times(by: float) -> Any:
        scaled = np.array(evidence.value) * by
        return float(scaled) if scaled.ndim == 0 else tuple(map(tuple, scaled.tolist()))

    low, high = (factor * bound / mass.value for bound in mass.bounds or (mass.value, mass.value))
    ends = np.stack([np.array(times(low)), np.array(times(high))])
    least, most = ends.min(axis=0), ends.max(axis=0)  # Products of inertia may be negative.
    return evidence.model_copy(
        update={
            "value": times(factor),
            "source": "inferred",
            "method": f"in proportion to the measured mass; before: {evidence.method}",
            "confidence": trust * mass.confidence,
            "bounds": tuple(float(e) if e.ndim == 0 else tuple(map(tuple, e.tolist())) for e in (least, most)),
        }
    )
