"""Reads a written scene back from disk, as a simulator would: every body, dynamic or static, with its world pose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from geom.convex.scaling import scaled_body
from schemas.arrays import FloatArray
from schemas.physics import MassProperties, RigidBody
from usdio.read.gprim_placement import column_matrix
from usdio.reread.body import body_of, contact_of, pose_in, shapes_of
from usdio.reread.one_body import one_body
from usdio.stage import open_stage

BACKGROUND = "/World/Background"
_STATIC_MASS = MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))


@dataclass(frozen=True)
class SceneBody:
    """One body of a scene: its shapes in its own frame at true size, and X_WA (4, 4) of that frame in the world.

    An articulated object is one body, its links held where the scene has them.
    """

    name: str
    body: RigidBody
    X_WA: FloatArray
    moves: bool


def reread_scene(file: Path) -> tuple[SceneBody, ...]:
    """The bodies below `/World/Background` and `/World/Objects`; scale is applied to shapes and mass centres.

    Names are those of the program. Raises InvalidInput (`asset/package-invalid`) as `reread_body` does.
    """
    stage = open_stage(file)
    prims = [prim for prim in (stage.GetPrimAtPath(BACKGROUND),) if prim]
    prims += stage.GetPrimAtPath("/World/Objects").GetChildren()
    return tuple(_scene_body(prim, file) for prim in prims)


def _scene_body(prim: Usd.Prim, file: Path) -> SceneBody:
    X_WA = column_matrix(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
    scale = float(np.cbrt(np.linalg.det(X_WA[:3, :3])))
    X_WA[:3, :3] /= scale
    links = [link for link in prim.GetChildren() if link.HasAPI(UsdPhysics.RigidBodyAPI)]
    if links:
        held = one_body(_name(prim), [(body_of(link, file), pose_in(link, prim)) for link in links])
        return SceneBody(held.name, scaled_body(held, scale), X_WA, prim.GetPath() != BACKGROUND)
    enabled = prim.HasAPI(UsdPhysics.RigidBodyAPI) and UsdPhysics.RigidBodyAPI(prim).GetRigidBodyEnabledAttr().Get()
    name = _name(prim)
    body = (
        body_of(prim, file) if enabled else RigidBody(name, shapes_of(prim, file), _STATIC_MASS, contact_of(prim, file))
    )
    return SceneBody(name, scaled_body(body, scale), X_WA, bool(enabled))


def _name(prim: Usd.Prim) -> str:
    return str(prim.GetCustomDataByKey("mana:id") or prim.GetName())
