"""Rule: every file an attribute names exists."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Sdf, Usd

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per asset-valued attribute (textures above all) whose path leads nowhere."""
    for prim in stage.Traverse():
        for attribute in prim.GetAuthoredAttributes():
            value = attribute.Get() if attribute.GetTypeName() == Sdf.ValueTypeNames.Asset else None
            if value is not None and value.path and not value.resolvedPath:
                yield finding("asset/gate-missing-file", "a file is missing", where=at(prim), value=value.path)
