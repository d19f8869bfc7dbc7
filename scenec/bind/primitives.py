"""Geometry of inline boxes, cylinders and spheres: collision shape, top surface and stable orientations."""

from __future__ import annotations

import numpy as np
import shapely

from geom.convex.circumscribed_hull import UNIT_CIRCLE
from geom.pose import pose
from schemas.physics import CollisionShape
from schemas.scene.geometry import ScenePlace
from schemas.scene.program import BoxAsset, CylinderAsset, Inline, SphereAsset

TOP = "top"
_H = float(np.sqrt(0.5))
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
# Orientations on each side: z up, x up, y up. Those turned over look the same.
_ON_X, _ON_Y = (_H, 0.0, -_H, 0.0), (_H, _H, 0.0, 0.0)


def shape_of(primitive: Inline) -> CollisionShape:
    """The shape in the asset frame: origin at the bottom centre."""
    if isinstance(primitive, BoxAsset):
        return CollisionShape("box", primitive.size_m, pose(p_AB=(0.0, 0.0, 0.5 * primitive.size_m[2])))
    if isinstance(primitive, SphereAsset):
        return CollisionShape("sphere", (primitive.radius_m,), pose(p_AB=(0.0, 0.0, primitive.radius_m)))
    size = (primitive.radius_m, primitive.height_m)
    return CollisionShape("cylinder", size, pose(p_AB=(0.0, 0.0, 0.5 * primitive.height_m)))


def top_of(primitive: Inline) -> tuple[ScenePlace, ...]:
    """The flat top; a round one is a polygon inscribed in the circle, so that contents stay on the top."""
    if isinstance(primitive, BoxAsset):
        x, y, z = primitive.size_m
        return (ScenePlace(TOP, shapely.box(-0.5 * x, -0.5 * y, 0.5 * x, 0.5 * y), np.array([0.0, 0.0, z])),)
    if isinstance(primitive, CylinderAsset):
        circle = shapely.Polygon(primitive.radius_m * UNIT_CIRCLE)
        return (ScenePlace(TOP, circle, np.array([0.0, 0.0, primitive.height_m])),)
    return ()


def stable_quats_wxyz(primitive: Inline) -> tuple[tuple[float, float, float, float], ...]:
    """Orientations of the asset frame in which it rests."""
    if isinstance(primitive, BoxAsset):
        return (UPRIGHT, _ON_X, _ON_Y)
    return (UPRIGHT, _ON_X) if isinstance(primitive, CylinderAsset) else (UPRIGHT,)
