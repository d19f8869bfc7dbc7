"""The form of a moved link against its joint axis, and its place against the rest of the object.

From points of both surfaces at rest (metres, one frame with z up) into lengths and shares that do not change when the
object turns about z, when the axis is reversed, or when the links are renamed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from geom.mesh.surface_distance import sample_surface
from schemas.arrays import FloatArray
from schemas.physics import Solid

SURFACE_SAMPLES = 3000  # per surface
# The middle 80 % of the surface tell how thick a leaf is: a handle on one side has less than a tenth of it.
CORE = (0.1, 0.9)
_TINY_M = 1e-9


@dataclass(frozen=True)
class MovedShape:
    """A moved link about the line through `anchor` (3,) along the unit vector `axis` (3,), at one position.

    points           (n, 3) samples of its surface, by area.
    along_m          lowest and highest coordinate along the axis, from the anchor.
    wide, thin       (3,) unit vectors across the axis: long and short side of the narrowest rectangle around it.
    wide_m, thin_m   lowest and highest coordinate along these, from the axis.
    core_thin_m      extent along `thin` of the middle 80 % of the surface: of a leaf without its handle.
    radius_m         greatest distance of a point from the axis.
    offset           distance of the middle of its rectangle from the axis, as a share of `radius_m`: 0 for what turns
                     about its own middle, 0.5 and more for what turns about an edge.
    """

    anchor: FloatArray
    axis: FloatArray
    points: FloatArray
    along_m: tuple[float, float]
    wide: FloatArray
    thin: FloatArray
    wide_m: tuple[float, float]
    thin_m: tuple[float, float]
    core_thin_m: float
    radius_m: float
    offset: float

    @property
    def length_m(self) -> float:
        """Extent along the axis."""
        return self.along_m[1] - self.along_m[0]

    @property
    def width_m(self) -> float:
        """Longer extent across the axis."""
        return self.wide_m[1] - self.wide_m[0]

    @property
    def thickness_m(self) -> float:
        """Shorter extent across the axis."""
        return self.thin_m[1] - self.thin_m[0]

    @property
    def edge(self) -> float:
        """Where the axis crosses the long side, as a share of it from the nearer end; negative outside of it."""
        low, high = self.wide_m
        return min(-low, high) / max(high - low, _TINY_M)

    @property
    def extents_m(self) -> tuple[float, float, float]:
        """Edges of the box along axis, wide and thin, sorted."""
        a, b, c = sorted((self.length_m, self.width_m, self.thickness_m))
        return a, b, c

    @property
    def diagonal_m(self) -> float:
        """Diagonal of that box."""
        return float(np.linalg.norm(self.extents_m))


def surface_points(solid: Solid) -> FloatArray:
    """(n, 3) samples of a surface by area, the same for the same triangles; then its corners."""
    samples, _ = sample_surface(solid.points, solid.triangles, SURFACE_SAMPLES, seed=0)
    return samples


def moved_shape(points: FloatArray, corners: FloatArray, anchor: FloatArray, axis: FloatArray) -> MovedShape:
    """The form of a link with surface samples `points` (n, 3) and `corners` (m, 3) about a line."""
    local = corners - anchor
    along = local @ axis
    across = local - along[:, None] * axis
    first, second = _basis(axis)
    flat = np.stack([across @ first, across @ second], axis=1)
    wide_2, thin_2 = _narrowest_rectangle(flat)
    wide, thin = wide_2[0] * first + wide_2[1] * second, thin_2[0] * first + thin_2[1] * second
    on_wide, on_thin = flat @ wide_2, flat @ thin_2
    core = np.quantile((points - anchor) @ thin, CORE)
    radius = float(np.linalg.norm(flat, axis=1).max())
    middle = np.array([0.5 * (on_wide.min() + on_wide.max()), 0.5 * (on_thin.min() + on_thin.max())])
    return MovedShape(
        anchor=anchor,
        axis=axis,
        points=points,
        along_m=(float(along.min()), float(along.max())),
        wide=wide,
        thin=thin,
        wide_m=(float(on_wide.min()), float(on_wide.max())),
        thin_m=(float(on_thin.min()), float(on_thin.max())),
        core_thin_m=float(core[1] - core[0]),
        radius_m=radius,
        offset=float(np.linalg.norm(middle)) / max(radius, _TINY_M),
    )


def box_around(points: FloatArray, heading: FloatArray) -> FloatArray:
    """Extents (3,) of the box around points (n, 3) with edges along `heading` (3,) (level), its normal, and z."""
    side = np.array([-heading[1], heading[0], 0.0])
    return np.array([float(np.ptp(points @ d)) for d in (heading, side, np.array([0.0, 0.0, 1.0]))])


def level_heading(points: FloatArray) -> FloatArray:
    """(3,) level direction of the long side of the narrowest upright box around points (n, 3)."""
    wide, _ = _narrowest_rectangle(points[:, :2])
    return np.array([wide[0], wide[1], 0.0])


def _basis(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors across the axis, at right angles."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, helper)
    first = np.asarray(first / np.linalg.norm(first), dtype=np.float64)
    return first, np.cross(axis, first)


def _narrowest_rectangle(flat: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Directions (2,) of the long and the short side of the rectangle of least area around points (n, 2)."""
    hull = shapely.MultiPoint(flat).convex_hull
    corners = shapely.get_coordinates(hull.minimum_rotated_rectangle)
    if len(corners) >= 4:
        sides = np.diff(corners[:3], axis=0)
        wide = sides[int(np.hypot(sides[:, 0], sides[:, 1]).argmax())]
    else:  # all on one line, or one point
        wide = flat.max(axis=0) - flat.min(axis=0)
    heading = math.atan2(float(wide[1]), float(wide[0]))
    x, y = math.cos(heading), math.sin(heading)
    return np.array([x, y]), np.array([-y, x])
