"""Rule: the visible size is possible and is the size that the metadata states."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Usd

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at, visible_points

LEAST_M, MOST_M = 1e-4, 1e4  # as `asset/scale-implausible`
_RELATIVE = 0.01


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding when nothing is visible, the longest edge is outside 0.1 mm .. 10 km, or `asset_extents` disagrees."""
    root = stage.GetDefaultPrim()
    if not root:
        return  # The default-prim rule says so.
    points = visible_points(stage, root)
    extent_m = np.ptp(points, axis=0) if len(points) else np.zeros(3)
    longest_m = float(extent_m.max())
    if not LEAST_M <= longest_m <= MOST_M:
        bound = LEAST_M if longest_m < LEAST_M else MOST_M
        yield finding(
            "asset/gate-extent",
            "the visible size is impossible",
            where=at(root),
            value=longest_m,
            bound=bound,
            unit="m",
        )
        return
    stated = stage.GetRootLayer().customLayerData.get("SimReady_Metadata", {}).get("asset_extents")
    if stated is not None and float(np.abs(np.asarray(stated) - extent_m).max()) > _RELATIVE * longest_m:
        yield finding(
            "asset/gate-extent",
            "the metadata state another size than the visible one",
            where=at(root),
            value=str(tuple(round(float(v), 6) for v in stated)),
            bound=str(tuple(round(float(v), 6) for v in extent_m)),
            unit="m",
        )
