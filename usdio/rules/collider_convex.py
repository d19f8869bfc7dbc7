"""Rule: mesh colliders of moving bodies are convex."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Iterator

from pxr import Usd, UsdGeom, UsdPhysics

from schemas.diagnostics import Diagnostic, finding
from usdio.reread import collider_prims
from usdio.rules.subject import at, bodies

_CONVEX = ("convexHull", "convexDecomposition", "boundingCube", "boundingSphere")


def check(stage: Usd.Stage) -> Iterator[Diagnostic]:
    """A finding per mesh collider of a body whose approximation is none of the convex ones.

    Simulators either refuse moving triangle meshes or let them fall through the floor.
    """
    for collider in (prim for body in bodies(stage) for prim in collider_prims(body)):
        if not collider.IsA(UsdGeom.Mesh):
            continue
        applied = collider.HasAPI(UsdPhysics.MeshCollisionAPI)
        value = UsdPhysics.MeshCollisionAPI(collider).GetApproximationAttr().Get() if applied else "none"
        if value not in _CONVEX:
            yield finding(
                "asset/gate-collider-not-convex",
                "a moving mesh collider is not convex",
                where=at(collider),
                value=str(value),
                bound="convexHull",
            )
