"""Rule: one root prim, which is the default prim, a component and transformable."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Kind, Usd, UsdGeom

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding for a missing default prim, further root prims, a wrong kind or a prim that cannot be placed."""
    prim = stage.GetDefaultPrim()
    if not prim:
        yield finding("asset/gate-default-prim", "there is no default prim")
        return
    roots = stage.GetPseudoRoot().GetChildren()
    if len(roots) != 1:
        yield finding("asset/gate-default-prim", "there are several root prims", value=len(roots), bound=1)
    if not prim.IsA(UsdGeom.Xformable):
        yield finding("asset/gate-default-prim", "the default prim has no transform", where=at(prim))
    kind = str(Usd.ModelAPI(prim).GetKind())
    if kind != Kind.Tokens.component:
        yield finding(
            "asset/gate-default-prim", "the default prim is no component", where=at(prim), value=kind, bound="component"
        )
