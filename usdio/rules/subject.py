"""What the rules look at: bodies, their colliders as points, the visible surface as points."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics
from scipy.spatial import ConvexHull, QhullError

from geom.pose import apply
from schemas.diagnostics import Location
from schemas.model import FloatArray
from usdio.reread import collider_prims, pose_in, visible_meshes


def bodies(stage: Usd.Stage) -> list[Usd.Prim]:
    """Prims with an enabled RigidBodyAPI, in stage order."""
    prims = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    return [prim for prim in prims if UsdPhysics.RigidBodyAPI(prim).GetRigidBodyEnabledAttr().Get()]


def mass_kg(body: Usd.Prim) -> float | None:
    """The body's mass when it is a positive finite number; other rules leave a broken mass to the mass rule."""
    value = UsdPhysics.MassAPI(body).GetMassAttr().Get() if body.HasAPI(UsdPhysics.MassAPI) else None
    return float(value) if value is not None and np.isfinite(value) and value > 0.0 else None


def mass_centre_m(body: Usd.Prim) -> FloatArray:
    """(3,) mass centre in the frame of the body prim."""
    return np.asarray(UsdPhysics.MassAPI(body).GetCenterOfMassAttr().Get(), dtype=np.float64)


def collider_points(body: Usd.Prim) -> FloatArray:
    """(n, 3) points on all colliders of the body, in its frame; round shapes are sampled, a few per cent inside."""
    clouds = [apply(pose_in(prim, body), _local_points(prim)) for prim in collider_prims(body)]
    return np.concatenate(clouds) if clouds else np.zeros((0, 3))


def visible_points(stage: Usd.Stage, ancestor: Usd.Prim) -> FloatArray:
    """(n, 3) points of the visible meshes below `ancestor`, in its frame."""
    meshes = [prim for prim in visible_meshes(stage) if prim.GetPath().HasPrefix(ancestor.GetPath())]
    clouds = [apply(pose_in(prim, ancestor), _local_points(prim)) for prim in meshes]
    return np.concatenate(clouds) if clouds else np.zeros((0, 3))


def hull(points: FloatArray) -> ConvexHull | None:
    """The convex hull of (n, 3) points, or None when they are flat or too few."""
    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None


def at(prim: Usd.Prim) -> Location:
    """The location of a prim."""
    return Location(prim=str(prim.GetPath()))


def _local_points(prim: Usd.Prim) -> FloatArray:
    if prim.IsA(UsdGeom.Mesh):
        points = UsdGeom.Mesh(prim).GetPointsAttr().Get()  # None in a file that is not ours
        return np.asarray(points if points is not None else [], dtype=np.float64).reshape(-1, 3)
    if prim.IsA(UsdGeom.Sphere):
        return UsdGeom.Sphere(prim).GetRadiusAttr().Get() * _sphere()
    if prim.IsA(UsdGeom.Capsule) or prim.IsA(UsdGeom.Cylinder):
        capsule = prim.IsA(UsdGeom.Capsule)
        gprim = UsdGeom.Capsule(prim) if capsule else UsdGeom.Cylinder(prim)
        ends = gprim.GetRadiusAttr().Get() * (_sphere() if capsule else _circle())
        half = np.array([0.0, 0.0, 0.5 * gprim.GetHeightAttr().Get()])
        shift = {"X": 1, "Y": 2, "Z": 0}[str(gprim.GetAxisAttr().Get())]
        return np.roll(np.concatenate([ends + half, ends - half]), shift, axis=1)
    corners = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
    return UsdGeom.Cube(prim).GetSizeAttr().Get() * corners if prim.IsA(UsdGeom.Cube) else np.zeros((0, 3))


def _circle() -> FloatArray:
    angle = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    return np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)


def _sphere() -> FloatArray:
    height = np.cos(np.linspace(0.0, np.pi, 17))[:, None]
    rings = np.sqrt(np.maximum(0.0, 1.0 - height**2))[:, :, None] * _circle()[None]
    return (rings + height[:, :, None] * np.array([0.0, 0.0, 1.0])).reshape(-1, 3)
