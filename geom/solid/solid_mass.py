"""Mass properties of a physical surface (`Solid`, metres) filled with one density in kg/m3.

The kind of the surface and its soundness choose the method; `geom.mass.inertia` has the integrals.
"""

from __future__ import annotations

import numpy as np

from geom.convex.hull import convex_hull, thickness
from geom.mass.inertia import is_physical, moved, of_box, of_closed_surface, of_sheet
from schemas.arrays import FloatArray
from schemas.physics import MassProperties, Solid

# A hull thinner than this share of its diagonal says nothing about volume; a plate of the assumed wall does.
FLAT_SHARE = 1e-3
PLATE_WALL_M = 1e-3


def mass_properties(solid: Solid, density_kgm3: float) -> tuple[MassProperties, str, float]:
    """Mass properties of a physical surface filled with one density, the method, and a confidence in 0..1.

    First that applies: volume of the closed surface, open surface times wall thickness, volume of the convex hull,
    oriented box (flat remains; at least `PLATE_WALL_M` thick). The confidence is about the geometry alone, not about
    the density or about what is inside. Raises ValueError when the surface has no area and no extent.
    """
    if solid.kind == "closed":
        closed = of_closed_surface(solid.points, solid.triangles, density_kgm3)
        if closed.mass_kg > 0.0 and is_physical(closed.inertia_kgm2):
            return closed, "volume of the closed surface", 0.95
    if solid.kind == "shell" and solid.wall_thickness_m is not None:
        sheet = of_sheet(solid.points, solid.triangles, solid.wall_thickness_m, density_kgm3)
        if sheet.mass_kg > 0.0:
            return sheet, "area times wall thickness", 0.5
    try:
        points, triangles = convex_hull(solid.points)
        if thickness(points, triangles) > FLAT_SHARE * np.linalg.norm(np.ptp(points, axis=0)):
            return of_closed_surface(points, triangles, density_kgm3), "volume of the convex hull", 0.3
    except ValueError:
        pass  # Flat: the box below stands in.
    return _of_bounding_plate(solid.points, density_kgm3), "oriented box", 0.15


def _of_bounding_plate(points: FloatArray, density_kgm3: float) -> MassProperties:
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
    return moved(of_box(np.maximum(size, PLATE_WALL_M), density_kgm3), X_AB)
