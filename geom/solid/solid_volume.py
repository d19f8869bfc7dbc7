"""Volume, centre and second moment of a physical surface (`Solid`, metres).

The kind of the surface and its soundness choose the method; `geom.mass.inertia` has the integrals.
"""

from __future__ import annotations

import numpy as np

from geom.convex.hull import convex_hull, thickness
from geom.mass.inertia import box_volume, enclosed_volume, is_physical, sheet_volume
from schemas.arrays import FloatArray
from schemas.physics import Solid, VolumeProperties

# A hull thinner than this share of its diagonal says nothing about volume; a plate of the assumed wall does.
FLAT_HULL_SHARE = 1e-3
PLATE_WALL_M = 1e-3


def volume_properties(solid: Solid) -> tuple[VolumeProperties, str, float]:
    """Volume properties of a physical surface, the method, and a confidence in 0..1.

    First that applies: volume of the closed surface, open surface times wall thickness, volume of the convex hull,
    oriented box (flat remains; at least `PLATE_WALL_M` thick). The confidence is about the outer geometry, not about
    what is inside. Raises ValueError when the surface has no area and no extent.
    """
    if solid.kind == "closed":
        closed = enclosed_volume(solid.points, solid.triangles)
        if closed.volume_m3 > 0.0 and is_physical(closed.second_moment_m5):
            return closed, "volume of the closed surface", 0.95
    if solid.kind == "shell" and solid.wall_thickness_m is not None:
        sheet = sheet_volume(solid.points, solid.triangles, solid.wall_thickness_m)
        if sheet.volume_m3 > 0.0:
            return sheet, "area times wall thickness", 0.5
    try:
        points, triangles = convex_hull(solid.points)
        if thickness(points, triangles) > FLAT_HULL_SHARE * np.linalg.norm(np.ptp(points, axis=0)):
            return enclosed_volume(points, triangles), "volume of the convex hull", 0.3
    except ValueError:
        pass  # Flat: the box below stands in.
    return _bounding_plate(solid.points), "oriented box", 0.15


def _bounding_plate(points: FloatArray) -> VolumeProperties:
    """The box along the principal directions of the points, at least as thick as a plate."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    centred = points - middle
    axes = np.linalg.eigh(centred.T @ centred)[1]
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    along = centred @ axes
    size = np.ptp(along, axis=0)
    if not size.max() > 0.0:
        raise ValueError("all points coincide")
    X_AB = np.eye(4)
    X_AB[:3, :3] = axes
    X_AB[:3, 3] = middle + axes @ (0.5 * (along.min(axis=0) + along.max(axis=0)))
    return box_volume(np.maximum(size, PLATE_WALL_M).tolist(), X_AB)
