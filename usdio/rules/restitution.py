"""Rule: restitution lies in 0 .. 1."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Usd

from schemas.diagnostics import Diagnostic, finding
from usdio.reread import bound_contact_material, collider_prims
from usdio.rules.subject import at, bodies


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per contact material whose restitution would add energy or is negative."""
    seen: set[str] = set()
    for collider in (prim for body in bodies(stage) for prim in collider_prims(body)):
        material = bound_contact_material(collider)
        if material is None or str(material.GetPath()) in seen:
            continue
        seen.add(str(material.GetPath()))
        value = material.GetRestitutionAttr().Get()
        if not 0.0 <= value <= 1.0:
            yield finding(
                "asset/gate-restitution",
                "restitution is outside 0 .. 1",
                where=at(material.GetPrim()),
                value=value,
                bound=0.0 if value < 0.0 else 1.0,
            )
