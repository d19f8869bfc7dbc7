"""Convex decomposition of a body into few hulls close to its shape: cut by planes, merged, trimmed, offset (metres)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold, OpType

from geom.decomposition.merge_hulls import merge_hulls
from geom.decomposition.offset_hulls import offset_hulls
from geom.decomposition.plane_cuts import CutGoal, cut_apart
from geom.decomposition.simplified_body import SimplifiedBody
from geom.decomposition.trim_hulls import FAR, trim_hulls
from geom.features.cavities import Cavity, keeps_cavity
from geom.mesh.manifold_arrays import manifold_arrays
from geom.mesh.surface_distance import SignedDistance, sample_surface
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

# Empty volume in all hulls, as a share of the body's: left by cutting; added by merging below the allowed number, where
# the hulls are close enough to the body.
CUT_SLACK, JOIN_SPARE = 0.03, 0.02
# A hull should not extend further out of the body than this share of its diagonal.
MAX_EXCESS_SHARE = 0.03
EXCESS_SAMPLES = 100
# Trimming starts above this ratio of volumes, and goes as deep as it takes of these shares of the diagonal.
TRIM_ABOVE, TRIM_DEPTHS = 1.1, (0.0075, 0.015, 0.0225, 0.03)
BLOCKED = 100.0  # Larger than any relative excess.


def convex_parts(
    body: SimplifiedBody,
    seeds: Sequence[Manifold],
    cavities: Sequence[Cavity] = (),
    most: int = 32,
    pieces: int = 80,
    balance: float = 1.25,
) -> list[FloatArray]:
    """Points (k_i, 3) in metres of at most `most` convex hulls, more only when joining any two would close a cavity.

    `seeds` (unit frame) fill the body, for instance its connected parts; each is cut further where its hull holds
    empty space, extends out of the body or into one of `cavities` (metres), until there are `pieces`: more than twice
    the allowed number of hulls, so that merging has a choice. `balance` as in `plane_cuts.Goal`.
    Deterministic.
    """
    distance = SignedDistance(*manifold_arrays(body.simplified))

    def relative_excess(hull: Manifold) -> float:
        """How far the hull extends out of the body, as a share of the allowed distance."""
        samples = sample_surface(*manifold_arrays(hull), EXCESS_SAMPLES, 0)[0]
        return max(float(distance(samples).max()) / (MAX_EXCESS_SHARE * body.size), 0.0)

    def blocks(hull: Manifold) -> bool:
        points, triangles = manifold_arrays(hull)
        shape = CollisionShape("hull", (), np.eye(4), body.in_metres(points), triangles.astype(np.int32))
        return not all(keeps_cavity([shape], cavity) for cavity in cavities)

    def violation(hull: Manifold) -> float:
        return BLOCKED if blocks(hull) else max(relative_excess(hull) - 1.0, 0.0)

    def merge_violation(hull: Manifold) -> float:
        return np.inf if blocks(hull) else relative_excess(hull)

    volume = body.simplified.volume()
    cut = cut_apart(seeds, CutGoal(CUT_SLACK, pieces, violation, balance))
    hulls = merge_hulls([piece.hull for piece in cut], most, violation=merge_violation)
    if _union_volume(hulls) <= TRIM_ABOVE * volume:
        hulls = merge_hulls(hulls, most, JOIN_SPARE * volume, merge_violation)
    trimmed, far, insides = hulls, 0.0, [hull ^ body.simplified for hull in hulls]  # evaluated when first needed
    for depth in TRIM_DEPTHS:
        if _union_volume(trimmed) <= TRIM_ABOVE * volume:
            break
        # Deeper is not always thinner: what is a bulge at one depth may be a flat end at another.
        far = FAR * depth * body.size
        deeper = trim_hulls(hulls, insides, distance, depth * body.size)
        trimmed = min(trimmed, deeper, key=lambda hulls: sum(hull.volume() for hull in hulls))
    if far > 0.0:
        trimmed = offset_hulls(trimmed, distance, far, lambda hull: not blocks(hull))
    return [body.in_metres(manifold_arrays(hull)[0]) for hull in trimmed]


def _union_volume(hulls: Sequence[Manifold]) -> float:
    return Manifold.batch_boolean(list(hulls), OpType.Add).volume()
