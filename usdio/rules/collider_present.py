"""Rule: every dynamic body can be touched."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Usd

from schemas.diagnostics import Diagnostic, finding
from usdio.reread import collider_prims
from usdio.rules.subject import at, bodies


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body without an enabled collider, and one when there is no body at all."""
    found = bodies(stage)
    if not found:
        yield finding("asset/gate-no-collider", "there is no rigid body")
    for body in found:
        if not collider_prims(body):
            yield finding("asset/gate-no-collider", "the body has no enabled collider", where=at(body))
