"""Rule: bodies stand unscaled and unmirrored."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Usd, UsdGeom

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at, bodies

_TOLERANCE = 1e-4


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body whose transform, ancestors included, is no rigid motion: engines drop or misread the rest."""
    for body in bodies(stage):
        rows = np.array(UsdGeom.Xformable(body).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))[:3, :3]
        deviation = float(np.abs(rows @ rows.T - np.eye(3)).max())
        if deviation > _TOLERANCE or np.linalg.det(rows) < 0.0:
            yield finding(
                "asset/gate-body-scale",
                "the body is scaled, sheared or mirrored",
                where=at(body),
                value=str([round(float(np.linalg.norm(row)), 6) for row in rows]),
                bound="[1, 1, 1]",
            )
