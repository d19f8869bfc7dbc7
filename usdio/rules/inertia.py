"""Rule: the principal moments belong to some real mass distribution."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pxr import Usd, UsdPhysics

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at, bodies

_RELATIVE = 1e-4  # Moments and axes are stored in single precision.


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per body with a moment <= 0, with `I1 + I2 < I3`, or whose axes are no unit quaternion."""
    for body in bodies(stage):
        if not body.HasAPI(UsdPhysics.MassAPI):
            continue
        api = UsdPhysics.MassAPI(body)
        moments = np.sort(np.asarray(api.GetDiagonalInertiaAttr().Get(), dtype=np.float64))
        length = api.GetPrincipalAxesAttr().Get().GetLength()
        if not np.all(np.isfinite(moments)) or moments[0] <= 0.0:
            yield _found(body, "a principal moment of inertia is not positive", moments[0], 0.0)
        elif moments[0] + moments[1] < moments[2] * (1.0 - _RELATIVE):
            yield _found(body, "the moments of inertia break the triangle inequality", moments[2], sum(moments[:2]))
        if abs(length - 1.0) > _RELATIVE:
            yield finding(
                "asset/gate-inertia",
                "the principal axes are no unit quaternion",
                where=at(body),
                value=length,
                bound=1.0,
            )


def _found(body: Usd.Prim, headline: str, value: float, bound: float) -> Diagnostic:
    return finding("asset/gate-inertia", headline, where=at(body), value=float(value), bound=float(bound), unit="kg m2")
