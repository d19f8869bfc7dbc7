"""Rule: the asset and each of its bodies have a visible mesh."""

from __future__ import annotations

from collections.abc import Iterator

from pxr import UsdGeom

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import TIME, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-not-visible",
    "Nothing, or not all, of the asset can be seen",
    "Cameras see something else than contacts feel.",
    "give every body a visible mesh with purpose default and visibility inherited",
)
_SHOWN = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding when nothing is drawn, per body of a package without a visible mesh, per hidden or empty mesh."""
    if not subject.surfaces and (subject.released or subject.bodies):
        yield finding(CODE, "nothing is visible", where=at(subject.root), severity=subject.suspect_severity)
    if not subject.released:
        return
    if subject.surfaces:
        for body in subject.bodies:
            if not body.surfaces and body.colliders:
                headline = "the body has colliders but no visible mesh"
                yield finding(CODE, headline, where=at(body.prim), severity=Severity.WARNING)
    for prim in subject.meshes:
        imageable = UsdGeom.Imageable(prim)
        if imageable.ComputePurpose() in _SHOWN and imageable.ComputeVisibility(TIME) == UsdGeom.Tokens.invisible:
            yield finding(CODE, "a render mesh is hidden", where=at(prim), value="invisible", bound="inherited")
    for surface in subject.surfaces:
        if len(surface.points_W) == 0:
            yield finding(CODE, "a render mesh is empty", where=at(surface.prim))


RULE = Rule(CODE, "a visible mesh with points; none hidden", "UsdGeomImageable visibility and purpose", check)
