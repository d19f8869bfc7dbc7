"""Rule: joint limits are in order."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Usd, UsdPhysics

from schemas.diagnostics import Diagnostic, finding
from usdio.rules.subject import at


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per revolute or prismatic joint whose lower limit is above its upper one."""
    for prim in stage.Traverse():
        revolute = prim.IsA(UsdPhysics.RevoluteJoint)
        if not revolute and not prim.IsA(UsdPhysics.PrismaticJoint):
            continue
        joint = UsdPhysics.RevoluteJoint(prim) if revolute else UsdPhysics.PrismaticJoint(prim)
        lower, upper = joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()
        if not lower <= upper:
            yield finding(
                "asset/gate-joint-limits",
                "the lower joint limit is above the upper one",
                where=at(prim),
                value=lower,
                bound=upper,
                unit="deg" if revolute else "m",
            )
