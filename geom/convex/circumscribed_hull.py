"""Points (n, 3) whose convex hull encloses a convex collision shape: its corners, circumscribed where it is round."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import trimesh

from geom.pose import apply
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

CIRCLE_CORNERS = 32  # of the polygon around a circle: it extends 0.5 % beyond
_TURN = np.arange(CIRCLE_CORNERS) * (2.0 * np.pi / CIRCLE_CORNERS)
UNIT_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1)  # inscribed in the unit circle, counter-clockwise
CIRCUMSCRIBED_CIRCLE = UNIT_CIRCLE / np.cos(np.pi / CIRCLE_CORNERS)  # circumscribed


def circumscribed_hull(shape: CollisionShape) -> FloatArray:
    """(n, 3) points in the asset frame (metres) whose hull encloses the shape, exactly where its sides are flat."""
    if shape.points is not None:
        return apply(shape.X_AS, shape.points)
    if shape.kind == "box":
        signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        local = signs * np.asarray(shape.size_m)
    elif shape.kind == "cylinder":
        radius, height = shape.size_m
        local = np.concatenate(
            [
                np.column_stack([radius * CIRCUMSCRIBED_CIRCLE, np.full(CIRCLE_CORNERS, z)])
                for z in (-0.5 * height, 0.5 * height)
            ]
        )
    else:
        ball = _around_ball() * shape.size_m[0]
        half = 0.5 * shape.size_m[1] if shape.kind == "capsule" else 0.0
        local = np.concatenate([ball + np.array([0.0, 0.0, z]) for z in sorted({-half, half})])
    return apply(shape.X_AS, local)


def _around_ball() -> FloatArray:
    """(162, 3) corners of a polyhedron circumscribed about the unit ball."""
    ball: trimesh.Trimesh = cast(Any, trimesh.creation).icosphere(subdivisions=2)  # its keywords have no types
    return ball.vertices / np.abs(np.einsum("ij,ij->i", ball.face_normals, ball.triangles[:, 0])).min()
