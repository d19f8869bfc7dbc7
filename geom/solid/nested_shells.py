"""Closed bodies wholly inside the material of others: inner cores, or cavities whose shell lost its winding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.mass.inertia import enclosed_volume
from geom.mesh.manifold_arrays import signed_volume
from geom.solid.closed_bodies import Surface, as_manifold, unite
from schemas.physics import VolumeProperties

# Bodies below this share of the largest are negligible; this also bounds their number.
LEAST_BODY_SHARE = 1e-3
# Volume that may lie outside the surrounding body by rounding, as a share of the inner body.
SLACK_SHARE = 1e-6


def nested_volume(bodies: Sequence[Surface]) -> VolumeProperties | None:
    """The volume of the union of those `bodies` (closed, outward) wholly inside another one.

    None when there are none. Inside means in the material: a ball in the cavity of a hollow box is not.
    """
    volumes = np.array([signed_volume(*body) for body in bodies])
    free: list[Surface] = []
    cores: list[Surface] = []
    largest_first: list[int] = np.argsort(-volumes, kind="stable").tolist()
    for k in largest_first:
        if volumes[k] < LEAST_BODY_SHARE * volumes.max() or any(_lies_within(bodies[k], core) for core in cores):
            continue
        (cores if any(_lies_within(bodies[k], other) for other in free) else free).append(bodies[k])
    together = unite(cores) if cores else None
    return None if together is None else enclosed_volume(*together)


def _lies_within(inner: Surface, outer: Surface) -> bool:
    low, high = outer[0].min(axis=0), outer[0].max(axis=0)
    if (inner[0] <= low).any() or (inner[0] >= high).any():
        return False
    centre = 0.5 * (low + high)
    inner_solid, outer_solid = (as_manifold(points - centre, triangles) for points, triangles in (inner, outer))
    return not inner_solid.is_empty() and (inner_solid - outer_solid).volume() <= SLACK_SHARE * inner_solid.volume()
