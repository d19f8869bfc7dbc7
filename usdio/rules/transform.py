"""Rule: transforms are finite and invertible."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.rule import Rule
from usdio.subject import Subject
from usdio.subject.values import at, figure

CODE = "asset/gate-transform"
_LEAST_SCALE = 1e-9


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per body, collider or visible mesh whose world transform is NaN, infinite or flattens space."""
    colliders, surfaces = [c.prim for c in subject.colliders], list(subject.visible_prims)
    prims = {str(prim.GetPath()): prim for prim in [*(b.prim for b in subject.bodies), *colliders, *surfaces]}
    for prim in prims.values():
        matrix = subject.frames.matrix(prim)
        if not np.all(np.isfinite(matrix)):
            yield finding(CODE, "the transform is not finite", where=at(prim), value=figure(matrix[:3, 3]))
            continue
        scale = np.linalg.norm(matrix[:3, :3], axis=0) / subject.frames.meters_per_unit
        if scale.min() < _LEAST_SCALE:
            headline = "the transform flattens the prim"
            yield finding(CODE, headline, where=at(prim), value=figure(scale), bound=_LEAST_SCALE)


RULE = Rule(CODE, "finite, scale above 1e-9", "UsdGeomXformable", check)
