"""A convex shape cut off at the faces of a box."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from geom.convex.hull import hull_shape
from geom.convex.support_function import surface
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape


def clipped_shape(shape: CollisionShape, low: FloatArray, high: FloatArray) -> CollisionShape | None:
    """What of a shape lies in the box `low`..`high` (3,) of its frame, as a hull; None where that is flat or nothing.

    A curved shape is inscribed; a shape that lies in the box is returned as it is.
    """
    points = surface(shape)[0]
    if (points >= low).all() and (points <= high).all():
        return shape
    if (points.max(axis=0) <= low).any() or (points.min(axis=0) >= high).any():
        return None
    box = Manifold.cube(np.subtract(high, low)).translate(np.asarray(low, dtype=np.float64))
    part = Manifold.hull_points(np.ascontiguousarray(points, dtype=np.float64)) ^ box
    if part.is_empty():
        return None
    return hull_shape(np.asarray(part.to_mesh().vert_properties, dtype=np.float64)[:, :3])
