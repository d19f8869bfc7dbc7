"""Collision shapes seen from another frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geom.pose import apply
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape


def moved_shape(shape: CollisionShape, X_BA: FloatArray) -> CollisionShape:
    """A shape given in frame A, in frame B; of hulls the points move, so that their pose stays the identity."""
    if shape.points is not None:
        return replace(shape, X_AS=np.eye(4), points=apply(X_BA @ shape.X_AS, shape.points))
    return replace(shape, X_AS=X_BA @ shape.X_AS)
