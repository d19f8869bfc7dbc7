"""Rule: the USD agrees with its record.json on size, category, mass properties and contact."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.category import UNKNOWN, labels, words
from gate.subject.values import STATED_TOLERANCE, at, format_numbers, number, quaternion, vector
from geom.mass.principal_axes import inertia_from_principal
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-record",
    "The USD and its record.json state different things",
    "One of the two was changed after release, so neither can be trusted.",
    "ingest the source again, or carry the change over into both",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per value of the record that the USD contradicts: size, category, mass properties, contact."""
    if subject.record is None:
        return
    where = at(subject.root)
    for quantity, unit, authored, stated in _figures(subject):
        scale = float(np.abs(stated).max())
        if authored.shape != stated.shape or not float(np.abs(authored - stated).max()) <= STATED_TOLERANCE * scale:
            headline = f"{quantity} is not that of the record"
            yield finding(
                CODE, headline, where=where, value=format_numbers(authored), bound=format_numbers(stated), unit=unit
            )
    category, class_labels = (
        subject.record_value("semantics", "category", "value"),
        labels(subject.root).get("class", ()),
    )
    known = isinstance(category, str) and category not in UNKNOWN
    if known and class_labels and all(words(label) != words(category) for label in class_labels):
        headline = "the class label is not the category of the record"
        yield finding(CODE, headline, where=where, value=", ".join(class_labels), bound=category)


def _figures(subject: Subject) -> Iterator[tuple[str, str, np.ndarray, np.ndarray]]:
    """(name, unit, value in the USD, value in the record)."""
    extent = _array(subject, "geometry", "extent_m")
    if extent is not None and len(subject.visible_points_W):
        yield "the size", "m", np.ptp(subject.visible_points_W, axis=0), extent
    mass, bodies = _array(subject, "physics", "mass_kg"), subject.active_bodies
    if mass is not None and bodies:
        yield "the mass", "kg", np.array(sum(body.mass_kg or 0.0 for body in bodies)), mass
    if len(bodies) == 1:
        yield from _one_body(subject, bodies[0])
    density = _array(subject, "physics", "density_kgm3")
    for prim in subject.contact_materials if len(subject.contact_materials) == 1 else ():
        if density is not None:
            yield (
                "the density of the contact material",
                "kg/m3",
                np.array(number(prim, "physics:density", 0.0)),
                density,
            )
        for name, key in (
            ("staticFriction", "static_friction"),
            ("dynamicFriction", "dynamic_friction"),
            ("restitution",) * 2,
        ):
            stated = _contact(subject, key)
            if stated is not None:
                yield name, "", np.array(number(prim, f"physics:{name}", 0.0)), np.array(stated)


def _one_body(subject: Subject, body: Body) -> Iterator[tuple[str, str, np.ndarray, np.ndarray]]:
    centre, inertia = _array(subject, "physics", "centre_of_mass_m"), _array(subject, "physics", "inertia_kgm2")
    if centre is not None and body.diagonal_m > 0.0:
        # Lengths near zero are judged against the size of the body, not against themselves.
        authored = vector(body.prim, "physics:centerOfMass", (0.0, 0.0, 0.0))
        if float(np.abs(authored - centre).max()) > STATED_TOLERANCE * body.diagonal_m:
            yield "the mass centre", "m", authored, centre
    shapes = _shapes(subject)
    if shapes is not None:
        yield "the number of colliders", "", np.array(len(body.active_colliders)), np.array(shapes)
    quat_wxyz = quaternion(body.prim, "physics:principalAxes")
    if inertia is not None and np.all(np.isfinite(quat_wxyz)) and np.any(quat_wxyz):
        moments = vector(body.prim, "physics:diagonalInertia", (0.0, 0.0, 0.0))
        yield "the inertia", "kg m2", inertia_from_principal(moments, quat_wxyz), inertia


def _array(subject: Subject, section: str, key: str) -> np.ndarray | None:
    """The numbers of an Evidence; None where the record has another form."""
    try:
        array = np.asarray(subject.record_value(section, key, "value"), dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return array if array.size and np.all(np.isfinite(array)) else None


def _shapes(subject: Subject) -> int | None:
    """How many shapes the chosen collision candidate has."""
    method, candidates = (
        subject.record_value("physics", "collision_method"),
        subject.record_value("physics", "candidates"),
    )
    for candidate in candidates if isinstance(candidates, list) else ():
        if isinstance(candidate, dict) and candidate.get("method") == method:
            shapes = candidate.get("shapes")
            return shapes if isinstance(shapes, int) else None
    return None


def _contact(subject: Subject, key: str) -> float | None:
    try:
        contacts = [c["value"] for c in subject.record_value("physics", "contacts")]
        return float(contacts[0][key]) if len(contacts) == 1 else None
    except (KeyError, TypeError, ValueError):
        return None


RULE = Rule(
    CODE,
    "size, mass, mass centre, inertia, density, friction to 0.1 %; category; number of colliders",
    "AssetRecord (`mana schema asset`)",
    check,
)
