"""Mirror symmetry: the vertical plane near a heading in which a surface is most symmetric, and the mean error."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from geom.mesh.surface_distance import NearestOnSurface, sample_surface
from schemas.arrays import FloatArray, IntArray

_MIRROR_SAMPLES = 600
_STEP_RAD = np.radians(3.0)
_XATOL_RAD = np.radians(0.02)


def mirror_plane_heading(
    points: FloatArray, triangles: IntArray, centre: FloatArray, near_rad: float, within_rad: float
) -> tuple[float, float] | None:
    """Heading (rad about z, from x) of the vertical plane through `centre` (3,) in which the surface, points (n, 3) and
    triangles (m, 3), is most nearly symmetric, and the mean distance of the mirror image from the surface.

    Only headings within `within_rad` of `near_rad` are tried; None when the best of them is at the border.
    """
    places, _ = sample_surface(points, triangles, _MIRROR_SAMPLES, 0)
    places = places - centre
    nearest = NearestOnSurface(points - centre, triangles)

    def off(heading: float) -> float:
        side = np.array([-np.sin(heading), np.cos(heading), 0.0])
        image = places - 2.0 * (places @ side)[:, None] * side
        return float(np.linalg.norm(nearest(image)[0] - image, axis=1).mean())

    steps = round(within_rad / _STEP_RAD)
    headings = [near_rad + _STEP_RAD * k for k in range(-steps, steps + 1)]
    best = int(np.argmin([off(h) for h in headings]))
    if best in (0, len(headings) - 1):
        return None
    bracket = (headings[best - 1], headings[best + 1])
    minimum = minimize_scalar(off, bounds=bracket, method="bounded", options={"xatol": _XATOL_RAD})
    return float(minimum.x), float(minimum.fun)
