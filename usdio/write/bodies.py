"""The bodies of a package: of a rigid object one at the default prim, of an articulated one a child prim per link."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from geom.convex.placement import moved_shape
from geom.pose import pose
from schemas.package import PackageContent
from schemas.physics import CollisionShape, MassProperties
from usdio.write.meshes import BodyFrame


class PackageBody(NamedTuple):
    """One body as it is written: its frame, shapes and mass in that frame, and which shapes of the object these are.

    `link` is "" for the body of a rigid object.
    """

    link: str
    frame: BodyFrame
    shapes: tuple[CollisionShape, ...]
    shape_indices: tuple[int, ...]
    mass: MassProperties


def package_bodies(content: PackageContent, root: Sdf.Path) -> tuple[PackageBody, ...]:
    """The bodies of the package whose default prim is `root`, the root link first."""
    if content.mechanism is None:
        everything = tuple(range(len(content.shapes)))
        return (PackageBody("", BodyFrame(root, np.zeros(3)), content.shapes, everything, content.mass),)
    bodies: list[PackageBody] = []
    for link, body in zip(content.mechanism.links, content.links, strict=True):
        X_LA = pose(None, -link.origin)
        shapes = tuple(moved_shape(content.shapes[i], X_LA) for i in body.shapes)
        mass = replace(body.mass, centre_of_mass_m=body.mass.centre_of_mass_m - link.origin)
        frame = BodyFrame(root.AppendChild(link.name), link.origin)
        bodies.append(PackageBody(link.name, frame, shapes, body.shapes, mass))
    return tuple(bodies)


def place_body(stage: Usd.Stage, body: PackageBody) -> Usd.Prim:
    """The prim of a body, at its frame; that of a rigid object is the default prim as it is."""
    if not body.link:
        return stage.GetPrimAtPath(body.frame.path)
    xform = UsdGeom.Xform.Define(stage, body.frame.path)
    if body.frame.origin_m.any():
        at = Gf.Vec3d(*(float(v) for v in body.frame.origin_m))
        xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(at)
    return xform.GetPrim()
