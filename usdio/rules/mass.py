"""Rule: every body has a positive, finite mass."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Usd, UsdPhysics

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at, bodies, mass_kg


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body whose mass is absent, zero, negative or not finite."""
    for body in bodies(stage):
        if mass_kg(body) is None:
            value = UsdPhysics.MassAPI(body).GetMassAttr().Get() if body.HasAPI(UsdPhysics.MassAPI) else "absent"
            yield finding(
                "asset/gate-mass", "the mass is not positive", where=at(body), value=value, bound=0.0, unit="kg"
            )
