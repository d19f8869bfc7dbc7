"""Hulls of curved walls moved to the middle of the wall they stand for.

Trimmed to the wall's thickness, the hull of a bent plate still lies on its chord: all of the bulge is missing, and on
the hollow side it stands as far out of the wall. Moved outward by some of that, it is off by half as much everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from manifold3d import Manifold

from geom.decomposition.simplified_body import arrays
from geom.decomposition.trim_hulls import outer_sides
from geom.mesh.surface_distance import SolidDistance, sample_surface

# Tried moves, as shares of how far the hollow side lies from the wall; the best is where most samples are nearest.
SHARES = (0.0, 0.2, 0.35, 0.5)
SAMPLES, NEAR_PERCENT = 200, 90.0


def raise_hulls(
    hulls: Sequence[Manifold], distance: SolidDistance, far: float, allowed: Callable[[Manifold], bool]
) -> list[Manifold]:
    """The hulls, each moved away from its largest empty side as far as that brings its surface nearer to the body's.

    `distance` is that to the surface of the body; an empty side lies more than `far` outside. A move must be `allowed`.
    """
    return [_raised(hull, distance, far, allowed) for hull in hulls]


def _raised(hull: Manifold, distance: SolidDistance, far: float, allowed: Callable[[Manifold], bool]) -> Manifold:
    empty = [normal for normal, is_empty in outer_sides(hull, distance, far) if is_empty]
    if not empty:
        return hull
    points, triangles = arrays(hull)
    # The sides come largest face first; the hollow one of a wall is the first that is empty.
    hollow = points[triangles].mean(axis=1)
    depth = float(distance(hollow[hollow @ empty[0] >= np.median(hollow @ empty[0])]).max())
    tried = [hull.translate((m[0], m[1], m[2])) for m in (-share * max(depth, 0.0) * empty[0] for share in SHARES)]
    return min((h for k, h in enumerate(tried) if k == 0 or allowed(h)), key=lambda h: _off(h, distance))


def _off(hull: Manifold, distance: SolidDistance) -> float:
    samples = sample_surface(*arrays(hull), SAMPLES, 0)[0]
    return float(np.percentile(np.abs(distance(samples)), NEAR_PERCENT))
