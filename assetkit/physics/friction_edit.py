"""Friction of a body changed by a factor within its bounds: an edit of a repair of acceptance."""

from __future__ import annotations

from dataclasses import replace

from assetkit.physics.build import PhysicsResult
from schemas.evidence import Evidence
from schemas.physics import Contact


def with_friction(built: PhysicsResult, gain: float) -> PhysicsResult:
    """The physics with `gain` times the friction of every contact record, none beyond its upper bound."""
    if gain == 1.0:
        return built
    contacts = tuple(_gained(evidence, gain) for evidence in built.section.contacts)
    section = built.section.model_copy(update={"contacts": contacts})
    return replace(built, contact=_times(built.contact, gain, built.section.contacts[0]), section=section)


def _gained(evidence: Evidence[Contact], gain: float) -> Evidence[Contact]:
    value = _times(evidence.value, gain, evidence)
    method = f"{evidence.method}; {gain:.3g} times, within its bounds, so that a gripper holds it"
    return evidence.model_copy(update={"value": value, "method": method})


def _times(contact: Contact, gain: float, evidence: Evidence[Contact]) -> Contact:
    static, dynamic = contact.static_friction * gain, contact.dynamic_friction * gain
    if evidence.bounds is not None:
        high = evidence.bounds[1]
        static, dynamic = min(static, high.static_friction), min(dynamic, high.dynamic_friction)
    return contact.model_copy(update={"static_friction": static, "dynamic_friction": dynamic})
