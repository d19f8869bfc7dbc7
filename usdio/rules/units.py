"""Rule: metres, kilograms, z up."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Usd, UsdGeom, UsdPhysics

from schemas.diagnostics import Diagnostic, finding


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """One finding per unit or axis that differs from metersPerUnit 1, kilogramsPerUnit 1, upAxis Z."""
    found = {
        "metersPerUnit": (UsdGeom.GetStageMetersPerUnit(stage), 1.0),
        "kilogramsPerUnit": (UsdPhysics.GetStageKilogramsPerUnit(stage), 1.0),
        "upAxis": (str(UsdGeom.GetStageUpAxis(stage)), "Z"),
    }
    for name, (value, bound) in found.items():
        if value != bound:
            yield finding("asset/gate-units", f"{name} is {value}, not {bound}", value=value, bound=bound)
