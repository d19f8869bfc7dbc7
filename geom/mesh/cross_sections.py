"""Horizontal cross-sections of a solid (metres) as shapely geometries in x and y."""

from __future__ import annotations

from functools import cached_property
from typing import Any, cast

import numpy as np
import shapely
import trimesh
from shapely.geometry.base import BaseGeometry

from geom.mesh.surface_distance import NearestOnSurface
from schemas.arrays import BoolArray
from schemas.physics import Solid

CUT_ROUNDING = 1e-7  # of the extent: ends of the cuts through two neighbouring faces coincide


class CrossSections:
    """Horizontal cross-sections of one solid; the cut mesh and the search tree are built once."""

    def __init__(self, solid: Solid) -> None:
        self.solid = solid
        self._mesh = trimesh.Trimesh(solid.points, solid.triangles, process=False)
        self._grid = CUT_ROUNDING * float(np.ptp(solid.points, axis=0).max())

    def outline_at(self, height_m: float) -> BaseGeometry:
        """The lines (x, y) in which the plane z = `height_m` cuts the faces, joined where they meet; may be empty."""
        cut: Any = cast(Any, trimesh.intersections).mesh_plane(self._mesh, [0.0, 0.0, 1.0], [0.0, 0.0, height_m])
        ends = np.asarray(cut, dtype=np.float64).reshape(-1, 2, 3)[:, :, :2]
        return shapely.union_all(shapely.linestrings(ends), grid_size=self._grid)

    def section_at(self, height_m: float) -> BaseGeometry:
        """The area (x, y) of the solid in the plane z = `height_m`; of a shell its cut walls, as thick as assumed."""
        lines = self.outline_at(height_m)
        if self.solid.kind == "shell":
            return lines.buffer(0.5 * (self.solid.wall_thickness_m or 0.0))
        faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
        if len(faces) == 0:
            return shapely.Polygon()
        middles = shapely.get_coordinates(shapely.point_on_surface(faces))
        inside: BoolArray = self._nearest.inside(np.column_stack([middles, np.full(len(middles), height_m)]))
        return shapely.union_all(faces[inside])

    @cached_property
    def _nearest(self) -> NearestOnSurface:
        return NearestOnSurface(self.solid.points, self.solid.triangles)
