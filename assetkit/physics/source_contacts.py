"""Friction and restitution of a body: as the source states them if plausible, else those of the material class."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.mass.substances import STATED_CONFIDENCE, STATED_TOLERANCE
from assetkit.taxonomy.material_classes import ANY, contacts_of, materials
from geom.mesh.surface_distance import triangle_areas
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import Mesh
from schemas.outcome import Repair
from schemas.physics import Contact
from schemas.stated_physics import StatedContact

CODE = "asset/source-friction-implausible"
# Soft rubber on a rough surface; glue is no friction.
MOST_FRICTION = 5.0


@dataclass(frozen=True)
class ContactEvidence:
    """Contact records, the one against any counterpart first, with findings and repairs on the source."""

    contacts: tuple[Evidence[Contact], ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def contact_evidence(
    material: Evidence[str], stated: Sequence[StatedContact], meshes: Sequence[Mesh]
) -> ContactEvidence:
    """Contact of one body of class `material`.

    A body has one contact material: of several stated ones that which covers most of the area of `meshes`. A value the
    file does not state comes from the class, in the class's ratio of static to dynamic friction. Pairs measured for the
    class are dropped when friction is stated, for they contradict it.
    """
    general = contacts_of(material)
    areas = [sum(_area(m) for m in meshes if m.source_path in s.covers) for s in stated]
    if not areas or max(areas) == 0.0:
        return ContactEvidence(general)
    chosen = stated[int(np.argmax(areas))]
    if (objection := _objection(chosen)) is not None:
        headline, value, bound = objection
        note = finding(CODE, headline, where=chosen.where, value=value, bound=bound)
        before: dict[str, float | int | str] = {"value": value, "bound": bound}
        after: dict[str, float | int | str] = {"value": f"material class {material.value}", "bound": bound}
        repair = Repair(name="implausible_friction", code=CODE, stage="physics", before=before, after=after)
        return ContactEvidence(general, (note,), (repair,))
    if chosen.static_friction is None and chosen.dynamic_friction is None and chosen.restitution is None:
        return ContactEvidence(general)
    contact = _completed(chosen, material)
    low, high = 1.0 - STATED_TOLERANCE, 1.0 + STATED_TOLERANCE
    unstated = [
        name for name in ("static_friction", "dynamic_friction", "restitution") if getattr(chosen, name) is None
    ]
    evidence = Evidence(
        value=contact,
        source="declared",
        method=chosen.method + (f"; {', '.join(unstated)} of material class {material.value}" if unstated else ""),
        confidence=STATED_CONFIDENCE if not unstated else 0.5 * STATED_CONFIDENCE,
        bounds=(_times(contact, low), _times(contact, high)),
        inputs=(str(chosen.where),),
    )
    return ContactEvidence((evidence,))


def _objection(stated: StatedContact) -> tuple[str, float | str, str] | None:
    """Why the values are implausible: headline, value, bound."""
    friction = [f for f in (stated.static_friction, stated.dynamic_friction) if f is not None]
    for value in friction:
        if not 0.0 <= value <= MOST_FRICTION:
            return "the stated friction is impossible", _shown(value), f"0..{MOST_FRICTION:g}"
    if len(friction) == 2 and friction[1] > friction[0]:
        return "the stated dynamic friction is above the static one", friction[1], f"0..{friction[0]:g}"
    if stated.restitution is not None and not 0.0 <= stated.restitution <= 1.0:
        return "the stated restitution is impossible", _shown(stated.restitution), "0..1"
    return None


def _completed(stated: StatedContact, material: Evidence[str]) -> Contact:
    row = materials()[material.value]
    ratio = row.dynamic_friction / row.static_friction
    static, dynamic = stated.static_friction, stated.dynamic_friction
    if static is None:
        static = row.static_friction if dynamic is None else dynamic / ratio
    if dynamic is None:
        dynamic = static * ratio
    restitution = row.restitution if stated.restitution is None else stated.restitution
    return Contact(
        counterpart=ANY,
        static_friction=static,
        dynamic_friction=dynamic,
        restitution=restitution,
        combine=stated.combine,
    )


def _times(contact: Contact, factor: float) -> Contact:
    return contact.model_copy(
        update={
            "static_friction": contact.static_friction * factor,
            "dynamic_friction": contact.dynamic_friction * factor,
            "restitution": min(1.0, contact.restitution * factor),
        }
    )


def _area(mesh: Mesh) -> float:
    return float(triangle_areas(mesh.points[mesh.triangles]).sum())


def _shown(value: float) -> float | str:
    return value if np.isfinite(value) else str(value)
