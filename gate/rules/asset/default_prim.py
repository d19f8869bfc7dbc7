"""Rule: one root prim, which is the default prim, a component and transformable."""

from __future__ import annotations

from collections.abc import Iterator

from pxr import Kind, Usd, UsdGeom

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Severity, finding

CODE = DiagnosticCode(
    "asset/gate-default-prim",
    "The package has no single, placeable component as its default prim",
    "Referencing the file would bring in nothing, or less than the asset.",
    "put everything under one Xform, make it the default prim with kind component",
)


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding for a missing default prim, further root prims, a wrong kind or a prim that cannot be placed."""
    stage = subject.stage
    prim = stage.GetDefaultPrim()
    if not prim:
        named = stage.GetRootLayer().defaultPrim
        headline = f"the default prim '{named}' does not exist" if named else "there is no default prim"
        yield finding(CODE, headline, severity=Severity.ERROR if named else subject.suspect_severity)
        return
    if not prim.IsActive() or prim.IsAbstract():
        yield finding(CODE, "the default prim is inactive or abstract", where=at(prim))
    roots = stage.GetPseudoRoot().GetChildren()
    if len(roots) > 1:
        yield finding(
            CODE, "there are several root prims", value=len(roots), bound=1, severity=subject.required_severity
        )
    if not prim.IsA(UsdGeom.Xformable):
        yield finding(CODE, "the default prim has no transform", where=at(prim), severity=subject.suspect_severity)
    kind = str(Usd.ModelAPI(prim).GetKind())
    if kind != Kind.Tokens.component:
        yield finding(
            CODE,
            "the default prim is no component",
            where=at(prim),
            value=kind,
            bound="component",
            severity=subject.required_severity,
        )


RULE = Rule(CODE, "one root Xform of kind component", "SimReady HI.001, HI.003, HI.004; UsdModelAPI", check)
