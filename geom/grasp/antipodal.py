"""Antipodal pairs: two points of a surface (metres) on which parallel pads can close without slipping.

Nguyen 1988, "Constructing force-closure grasps": two soft contacts hold an object when the line between them lies
inside both friction cones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.convex.convex_union import ConvexUnion
from schemas.arrays import FloatArray, IntArray

GRASP_SAMPLES = 1000
LEAST_M = 0.0005


@dataclass(frozen=True)
class AntipodalPairs:
    """Points first_m, second_m (k, 3) of the surface; angle_rad (k,) the larger angle of their line to a normal."""

    first_m: FloatArray
    second_m: FloatArray
    angle_rad: FloatArray

    @property
    def width_m(self) -> FloatArray:
        """(k,) distance between the two points."""
        return np.linalg.norm(self.second_m - self.first_m, axis=1)

    @property
    def axis(self) -> FloatArray:
        """(k, 3) unit vectors from first to second."""
        return (self.second_m - self.first_m) / self.width_m[:, None]

    @property
    def middle_m(self) -> FloatArray:
        """(k, 3) midpoints."""
        return 0.5 * (self.first_m + self.second_m)

    def take(self, index: IntArray) -> AntipodalPairs:
        """The pairs at `index`."""
        return AntipodalPairs(self.first_m[index], self.second_m[index], self.angle_rad[index])


def antipodal_pairs(union: ConvexUnion, cone_rad: float, widest_m: float) -> AntipodalPairs:
    """Pairs at most `widest_m` apart whose line lies within `cone_rad` of both normals.

    From samples of the surface along the inward normal: to the first exit (the wall of a mug) and to the last one (the
    whole mug).
    """
    starts, normals = union.outer_samples(GRASP_SAMPLES)
    exits = [union.first_exit(starts, -normals), union.last_exit(starts, -normals)]
    width = np.concatenate([r for r, _ in exits])
    outward = np.concatenate([n for _, n in exits])
    starts, normals = np.tile(starts, (2, 1)), np.tile(normals, (2, 1))
    angle = np.arccos(np.clip(np.einsum("ki,ki->k", outward, -normals), -1.0, 1.0))
    usable = np.isfinite(width) & (width >= LEAST_M) & (width <= widest_m) & (angle < cone_rad)
    usable[len(usable) // 2 :] &= exits[1][0] > exits[0][0] + LEAST_M  # The last exit must differ from the first.
    return AntipodalPairs(starts[usable], (starts - width[:, None] * normals)[usable], angle[usable])
