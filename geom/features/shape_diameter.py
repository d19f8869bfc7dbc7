"""Shape diameter function (Shapira, Shamir and Cohen-Or 2008): the thickness of a body below each triangle (m,).

The inside of a vessel counts as solid, so that a mug is as thick as it is wide and its handle stays thin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.features.heightfield import fill_depressions, heightfield, wall_points
from geom.features.regions import FaceGeometry
from geom.mesh.rays import Rays
from geom.pose import rotation_to_z
from schemas.arrays import BoolArray, FloatArray

_CONE_RAYS, _CONE_RAD = 24, np.radians(45.0)
_GOLDEN_ANGLE_RAD = np.pi * (3.0 - np.sqrt(5.0))


def shape_diameter(surface: FaceGeometry, inner: BoolArray) -> FloatArray:
    """(m,) lengths from each triangle inward to the far side: median over a cone, the diagonal where nothing is hit.

    Triangles where `inner` (m,) is True stop no ray; they get the diagonal. Directions follow each triangle's own
    edges, so a rotated surface has the same values.
    """
    diagonal = float(np.linalg.norm(surface.extent))
    outer = np.flatnonzero(~inner & (surface.area > 0.0))
    result = np.full(len(surface.triangles), diagonal)
    if len(outer) == 0:
        return result
    rays = Rays(surface.points, surface.triangles[outer])
    inward = -surface.normal[outer]
    corners = surface.points[surface.triangles[outer]]
    side = corners[:, 1] - corners[:, 0]
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    across = np.cross(inward, side)
    lean = _CONE_RAD * np.sqrt((np.arange(_CONE_RAYS) + 0.5) / _CONE_RAYS)
    turn = _GOLDEN_ANGLE_RAD * np.arange(_CONE_RAYS)
    starts = surface.middle[outer] + 1e-4 * diagonal * inward
    lengths = np.empty((_CONE_RAYS, len(outer)))
    for k in range(_CONE_RAYS):
        aim = np.cos(lean[k]) * inward + np.sin(lean[k]) * (np.cos(turn[k]) * side + np.sin(turn[k]) * across)
        lengths[k] = rays.hit_distances(starts, aim)
    result[outer] = np.minimum(np.median(lengths, axis=0), diagonal)
    return result


def faces_in_openings(surface: FaceGeometry, directions: Sequence[FloatArray]) -> BoolArray:
    """(m,) True at the triangles inside openings: below the filling level with one of `directions` (3,) up."""
    result = np.zeros(len(surface.triangles), dtype=bool)
    rays = Rays(surface.points, surface.triangles)
    walls = wall_points(surface.points, surface.triangles)
    for up in directions:
        frame = rotation_to_z(up)
        ground, _, step, corner = heightfield(rays, surface.points, walls, frame)
        level = fill_depressions(ground)
        for away in (1.0, 2.0):  # A wall may fill the cell it stands in, and hides the water there.
            place = (surface.middle + away * step * surface.normal) @ frame.T
            cell = np.rint((place[:, :2] - corner) / step).astype(int)
            x, y = np.clip(cell[:, 0], 0, ground.shape[0] - 1), np.clip(cell[:, 1], 0, ground.shape[1] - 1)
            result |= (place[:, 2] > ground[x, y]) & (place[:, 2] < level[x, y])
    return result
