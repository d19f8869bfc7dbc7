"""Rule: colliders have shapes that engines support without change."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import UsdGeom

from gate.rules.rule import Rule
from gate.subject import Collider, Subject
from gate.subject.body import diagonal
from gate.subject.values import at, format_numbers
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-collider-shape",
    "A collider has a shape engines do not take as it is",
    "Flat hulls abort MuJoCo, uneven spheres become something else, dents are filled up.",
    "give every hull volume, at most 64 points and no dents; scale round shapes evenly",
)
USUAL_POINTS, MOST_POINTS = 64, 255  # PhysX on a GPU, PhysX at all
MOST_COLLIDERS = 128
ROUND = ("Sphere", "Capsule", "Capsule_1", "Cylinder", "Cylinder_1", "Cone")
_SHAPE_TOLERANCE = 1e-3  # Single precision and tessellation stay well below.


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per collider without extent, per flat, heavy or dented hull, and per round shape scaled unevenly."""
    for collider in subject.colliders:
        if collider.enabled:
            yield from _shape(subject, collider)
    for body in subject.active_bodies:
        count = len(body.active_colliders)
        if count > MOST_COLLIDERS:
            headline = "the body has very many colliders"
            where = at(body.prim)
            severity = Severity.WARNING
            yield finding(CODE, headline, where=where, value=count, bound=MOST_COLLIDERS, severity=severity)


def _shape(subject: Subject, collider: Collider) -> Iterator[Diagnostic]:
    where, points = at(collider.prim), collider.points_W
    mesh = collider.prim.IsA(UsdGeom.Mesh)
    if not mesh and not collider.convex:
        if collider.prim.IsA(UsdGeom.Gprim):
            headline = f"engines know no collider of type {collider.prim.GetTypeName()}"
            yield finding(CODE, headline, where=where, severity=subject.suspect_severity)
        return
    if len(points) == 0:
        yield finding(CODE, "the collider has no extent: a size is missing, zero or no number", where=where)
        return
    if not np.all(np.isfinite(points)):
        return  # Reported by the mesh-values and transform rules.
    if collider.prim.GetTypeName() in ROUND:
        scale = np.linalg.norm(subject.frames.matrix(collider.prim)[:3, :3], axis=0) / subject.frames.meters_per_unit
        if np.ptp(scale) > _SHAPE_TOLERANCE * scale.max():
            headline = "a round collider is scaled unevenly"
            yield finding(CODE, headline, where=where, value=format_numbers(scale), severity=subject.suspect_severity)
    if collider.approximation != "convexHull":
        return
    if collider.hull_W is None:
        yield finding(
            CODE, "the collider's hull is flat: it has no volume", where=where, severity=subject.suspect_severity
        )
    elif subject.released:
        if len(points) > USUAL_POINTS:
            headline, count = "the hull has more points than engines take", len(points)
            severity = Severity.ERROR if count > MOST_POINTS else Severity.WARNING
            yield finding(CODE, headline, where=where, value=count, bound=USUAL_POINTS, severity=severity)
        normals, offsets = collider.hull_W.planes
        dent_m = float(-np.max(points @ normals.T - offsets, axis=1).min())
        bound_m = _SHAPE_TOLERANCE * diagonal(points)
        if dent_m > bound_m:
            headline = "the collider mesh is dented: engines fill it up to its hull"
            yield finding(CODE, headline, where=where, value=dent_m, bound=bound_m, unit="m")


RULE = Rule(
    CODE,
    "sizes > 0; hulls convex, with volume, of <= 64 points (error above 255); even scale; <= 128 a body",
    "PhysX and MuJoCo limits; SimReady RB.COL",
    check,
)
