"""Corners of convex collision shapes: what their hulls are spanned by, in the frame of the shapes (m)."""

from __future__ import annotations

from itertools import product

import numpy as np

from geom.pose import apply
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

ROUND_CORNERS = 32  # points on each rim of a round shape: within half a per cent of its radius


def shape_corners(shape: CollisionShape) -> FloatArray:
    """(k, 3) corners of a shape; round shapes by points on their rims and at their poles."""
    if shape.points is not None:
        return np.asarray(shape.points, dtype=np.float64)
    if shape.kind == "box":
        return apply(shape.X_AS, np.array(list(product((-0.5, 0.5), repeat=3))) * np.asarray(shape.size_m))
    radius, half = shape.size_m[0], 0.5 * shape.size_m[1] if len(shape.size_m) > 1 else 0.0
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND_CORNERS, endpoint=False)
    rim = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros_like(turn)], axis=1)
    ends = [rim + np.array([0.0, 0.0, sign * half]) for sign in (-1.0, 1.0)]
    if shape.kind != "cylinder":
        ends += [np.array([[0.0, 0.0, sign * (half + radius)]]) for sign in (-1.0, 1.0)]
    return apply(shape.X_AS, np.concatenate(ends))
