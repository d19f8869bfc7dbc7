"""Antipodal pairs: two places of a surface on which parallel pads can close without slipping.

Nguyen 1988, "Constructing force-closure grasps": two soft contacts hold an object when the line between them lies
inside both friction cones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geom.convex.convex_union import ConvexUnion
from schemas.model import FloatArray

SAMPLES = 1000
LEAST_M = 0.0005


@dataclass(frozen=True)
class Pairs:
    """first_m, second_m (k, 3) on the surface; angle_rad (k,) the larger angle of their line to a normal."""

    first_m: FloatArray
    second_m: FloatArray
    angle_rad: FloatArray

    @property
    def width_m(self) -> FloatArray:
        """(k,) how far the pads are apart."""
        return np.linalg.norm(self.second_m - self.first_m, axis=1)

    @property
    def axis(self) -> FloatArray:
        """(k, 3) unit vectors from first to second."""
        return (self.second_m - self.first_m) / self.width_m[:, None]

    @property
    def middle_m(self) -> FloatArray:
        """(k, 3) between the two places."""
        return 0.5 * (self.first_m + self.second_m)

    def take(self, index: FloatArray) -> Pairs:
        """Those at `index`."""
        return Pairs(self.first_m[index], self.second_m[index], self.angle_rad[index])


def antipodal_pairs(union: ConvexUnion, cone_rad: float, widest_m: float) -> Pairs:
    """Pairs at most `widest_m` apart whose line lies within `cone_rad` of both normals.

    From places spread over the surface along the inward normal: to where the matter there ends (the wall of a mug) and
    to the far side (the whole mug).
    """
    starts, normals = union.outer_samples(SAMPLES)
    found = [union.way_through(starts, -normals), union.last_exit(starts, -normals)]
    reach = np.concatenate([r for r, _ in found])
    outward = np.concatenate([n for _, n in found])
    starts, normals = np.tile(starts, (2, 1)), np.tile(normals, (2, 1))
    angle = np.arccos(np.clip(np.einsum("ki,ki->k", outward, -normals), -1.0, 1.0))
    kept = np.isfinite(reach) & (reach >= LEAST_M) & (reach <= widest_m) & (angle < cone_rad)
    kept[len(kept) // 2 :] &= found[1][0] > found[0][0] + LEAST_M  # The far side is not the near one again.
    return Pairs(starts[kept], (starts - reach[:, None] * normals)[kept], angle[kept])
