"""Offsets of the hulls of curved walls: each hull is moved outward to the middle of the wall that it represents.

Trimmed to the wall's thickness, the hull of a bent plate still lies on its chord: all of the bulge is missing, and on
the hollow side it extends as far out of the wall. Moved outward by part of that, its error is half as large.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from manifold3d import Manifold

from geom.decomposition.trim_hulls import outer_sides
from geom.mesh.manifold_arrays import manifold_arrays
from geom.mesh.surface_distance import SignedDistance, sample_surface

# Candidate offsets, as shares of the distance of the hollow side from the wall; the nearest hull is taken.
SHARES = (0.0, 0.2, 0.35, 0.5)
HULL_SAMPLES, NEAR_PERCENT = 200, 90.0


def offset_hulls(
    hulls: Sequence[Manifold], distance: SignedDistance, far: float, allowed: Callable[[Manifold], bool]
) -> list[Manifold]:
    """The hulls, each moved away from its largest empty side as far as its surface comes nearer to that of the body.

    `distance` is that to the surface of the body; an empty side lies more than `far` outside. A move must be `allowed`.
    """
    return [_raised(hull, distance, far, allowed) for hull in hulls]


def _raised(hull: Manifold, distance: SignedDistance, far: float, allowed: Callable[[Manifold], bool]) -> Manifold:
    empty = [normal for normal, is_empty in outer_sides(hull, distance, far) if is_empty]
    if not empty:
        return hull
    points, triangles = manifold_arrays(hull)
    # The sides come largest face first; the hollow one of a wall is the first that is empty.
    hollow = points[triangles].mean(axis=1)
    depth = float(distance(hollow[hollow @ empty[0] >= np.median(hollow @ empty[0])]).max())
    tried = [hull.translate((m[0], m[1], m[2])) for m in (-share * max(depth, 0.0) * empty[0] for share in SHARES)]
    return min((h for k, h in enumerate(tried) if k == 0 or allowed(h)), key=lambda h: _off(h, distance))


def _off(hull: Manifold, distance: SignedDistance) -> float:
    samples = sample_surface(*manifold_arrays(hull), HULL_SAMPLES, 0)[0]
    return float(np.percentile(np.abs(distance(samples)), NEAR_PERCENT))
