"""Preparation of a decomposition: a closed surface (metres) as a manifold of unit size, with fewer faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from manifold3d import Error, Manifold, OpType

from geom.mesh.manifold_arrays import manifold_arrays, manifold_of
from geom.mesh.surface_distance import SignedDistance
from schemas.arrays import FloatArray, IntArray

# Simplification errors tried, coarse to fine, in units of half the largest extent.
ERRORS = (0.01, 0.005, 0.0025, 0.00125)
# A part keeps its shape when its volume changes by less than this share and 99 % of its points stay within so many
# errors of the simplified surface. Filled slits do not count.
VOLUME_CHANGE, LOST_ERRORS, LOST_PERCENT = 0.02, 2.0, 99.0
PROBES = 4000


@dataclass(frozen=True)
class SimplifiedBody:
    """A solid in its unit frame (centred, largest half extent 1): `p_m = centre_m + scale_m * p`.

    full        every face, sealed inner cavities filled.
    simplified  the same shape with fewer faces.
    """

    full: Manifold
    simplified: Manifold
    centre_m: FloatArray
    scale_m: float

    @property
    def size(self) -> float:
        """Diagonal of the bounding box in the unit frame."""
        box = np.asarray(self.full.bounding_box())
        return float(np.linalg.norm(box[3:] - box[:3]))

    def in_metres(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) of the unit frame in the frame of the solid."""
        return self.centre_m + self.scale_m * points


def simplify_body(points: FloatArray, triangles: IntArray) -> SimplifiedBody:
    """The body inside a closed outward surface (metres), points (n, 3) and triangles (m, 3).

    Raises ValueError with the reason when there is none: nothing finite, no extent, not a closed oriented manifold.
    """
    if len(points) == 0 or len(triangles) == 0:
        raise ValueError("the surface is empty")
    if not np.isfinite(points).all():
        raise ValueError("a coordinate is not finite")
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise ValueError("a triangle refers to a point that does not exist")
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    scale = 0.5 * float(np.ptp(points, axis=0).max())
    if not scale > 0.0:
        raise ValueError("the surface has no extent")
    body = manifold_of((points - centre) / scale, triangles)
    if body.status() != Error.NoError or not body.volume() > 0.0:
        raise ValueError("the surface is not a closed manifold")
    whole = _without_cavities(body)
    return SimplifiedBody(whole, Manifold.compose([simplified(part) for part in whole.decompose()]), centre, scale)


def simplified(part: Manifold) -> Manifold:
    """`part` with the fewest faces that keep its shape; itself when even the least error is too much (a thin wall)."""
    for error in ERRORS:
        light = part.simplify(error)
        if abs(light.volume() - part.volume()) <= VOLUME_CHANGE * part.volume() and _covers(light, part, error):
            return light
    return part


def _without_cavities(body: Manifold) -> Manifold:
    """The body without sealed cavities: nothing touches their walls, which would only cost hulls."""
    parts = body.decompose()
    outer = [part for part in parts if part.volume() > 0.0]
    return body if len(outer) == len(parts) else Manifold.batch_boolean(outer, OpType.Add)


def _covers(light: Manifold, part: Manifold, error: float) -> bool:
    if light.num_tri() == part.num_tri():
        return True
    points = manifold_arrays(part)[0]
    beyond = SignedDistance(*manifold_arrays(light))(points[:: -(-len(points) // PROBES)])
    return bool(np.percentile(beyond, LOST_PERCENT) <= LOST_ERRORS * error)
