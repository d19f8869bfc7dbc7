"""Horizontal cuts through a surface, as polygons in x and y."""

from __future__ import annotations

import numpy as np
import shapely
import trimesh
from shapely.geometry.base import BaseGeometry

from geom.surface_distance import NearestOnSurface
from schemas.model import FloatArray
from schemas.physics import Solid

ROUNDING = 1e-7  # of the extent: ends of cuts through two faces meet


def outline_at(solid: Solid, height_m: float) -> BaseGeometry:
    """The lines in which the plane z = `height_m` cuts the faces, joined where they meet; empty where it misses."""
    mesh = trimesh.Trimesh(solid.points, solid.triangles, process=False)
    segments = trimesh.intersections.mesh_plane(mesh, [0.0, 0.0, 1.0], [0.0, 0.0, height_m])
    ends = np.asarray(segments, dtype=np.float64).reshape(-1, 2, 3)[:, :, :2]
    grid = ROUNDING * float(np.ptp(solid.points, axis=0).max())
    return shapely.union_all(shapely.linestrings(ends), grid_size=grid)


def matter_at(solid: Solid, height_m: float) -> BaseGeometry:
    """What the plane z = `height_m` cuts out of a solid; of a sheet its walls, of the thickness assumed."""
    lines = outline_at(solid, height_m)
    if solid.kind == "shell":
        return lines.buffer(0.5 * (solid.wall_thickness_m or 0.0))
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    if len(faces) == 0:
        return shapely.Polygon()
    middles = shapely.get_coordinates(shapely.point_on_surface(faces))
    inside: FloatArray = NearestOnSurface(solid.points, solid.triangles).inside(
        np.column_stack([middles, np.full(len(middles), height_m)])
    )
    return shapely.union_all(faces[inside])
