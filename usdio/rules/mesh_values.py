"""Rule: points, normals and texture coordinates are finite."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.rule import Rule
from usdio.subject import Subject
from usdio.subject.values import at, rows

CODE = "asset/gate-mesh-values"
ARRAYS = {"points": 3, "normals": 3, "primvars:normals": 3, "primvars:st": 2, "extent": 3, "primvars:displayColor": 3}


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per array of a mesh that holds NaN or infinity."""
    for prim in subject.meshes:
        for name, width in ARRAYS.items():
            values = rows(prim, name, width)
            broken = int((~np.isfinite(values)).any(axis=1).sum())
            if broken:
                headline = f"{name} holds NaN or infinity"
                yield finding(CODE, headline, where=at(prim), value=broken, bound=0, unit="values")


RULE = Rule(CODE, "finite", "a single NaN poisons bounds, shading and contacts", check)
