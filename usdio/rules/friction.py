"""Rule: every collider has a contact material, with static >= dynamic >= 0 friction."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Usd

from schemas.diagnostics import Diagnostic, finding
from usdio.reread import bound_contact_material, collider_prims
from usdio.rules.subject import at, bodies


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per collider without contact material, and per material with impossible friction."""
    seen: set[str] = set()
    for collider in (prim for body in bodies(stage) for prim in collider_prims(body)):
        material = bound_contact_material(collider)
        if material is None:
            yield finding("asset/gate-friction", "the collider has no contact material", where=at(collider))
            continue
        if str(material.GetPath()) in seen:
            continue
        seen.add(str(material.GetPath()))
        static, dynamic = material.GetStaticFrictionAttr().Get(), material.GetDynamicFrictionAttr().Get()
        where = at(material.GetPrim())
        if not dynamic >= 0.0:
            yield finding("asset/gate-friction", "dynamic friction is negative", where=where, value=dynamic, bound=0.0)
        if not static >= dynamic:
            yield finding(
                "asset/gate-friction", "static friction is below dynamic", where=where, value=static, bound=dynamic
            )
