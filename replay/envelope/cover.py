"""Balls that provably contain a body: no point of its collision shapes lies outside their union.

The proof is by convexity, not by samples. A convex solid is cut in two along its longest side again and again; a piece
is the hull of its corners, so a ball that holds the corners holds the piece, and the pieces fill the solid. Cutting
ends where the best ball around a piece sticks out of the solid by no more than is allowed; then as few balls as hold
all pieces are kept (greedy set cover, Johnson 1974). `residual_m` bounds what rounding may leave out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from geom.convex.circumscribed_hull import circumscribed_hull
from schemas.arrays import FloatArray, IntArray
from schemas.physics import CollisionShape

_FINEST = 0.03  # least protrusion over the size of a solid: balls needed grow with its inverse square on thin plates
_STEPS = 40  # towards the best ball around a piece
_LEAST_PIECE = 0.25  # pieces this share of the protrusion across are not cut further
_FLAT = 1e-7  # thinner than this share of the size, Qhull and the cuts find no volume
_ROUNDING = 1e-9  # of the body's size: far above the rounding of sums of coordinates in double precision


@dataclass(frozen=True)
class Cover:
    """Balls in the body's frame: centres_B (k, 3) and radii_m (k,).

    residual_m    proven bound on how far any point of the body may lie outside all balls (rounding).
    protrusion_m  proven bound on how far any point of a ball lies outside the body.
    """

    centres_B: FloatArray
    radii_m: FloatArray
    residual_m: float
    protrusion_m: float


@dataclass(frozen=True)
class _Solid:
    """A convex solid as outward planes: x inside where normals @ x <= offsets."""

    normals: FloatArray
    offsets: FloatArray

    def depth(self, points: FloatArray) -> FloatArray:
        """(k,) distance to the nearest plane, negative outside."""
        return (self.offsets - points @ self.normals.T).min(axis=1)


def cover(shapes: Sequence[CollisionShape], protrusion_m: float) -> Cover:
    """Balls around convex shapes. No shapes, no balls.

    None protrudes by more than `protrusion_m`, or 3 % of the size of its shape where that is more.
    """
    parts = [_ball(s) if s.kind == "sphere" else _polytope(circumscribed_hull(s), protrusion_m) for s in shapes]
    if not parts:
        return Cover(np.zeros((0, 3)), np.zeros(0), 0.0, 0.0)
    return Cover(
        np.concatenate([part.centres_B for part in parts]),
        np.concatenate([part.radii_m for part in parts]),
        max(part.residual_m for part in parts),
        max(part.protrusion_m for part in parts),
    )


def _ball(shape: CollisionShape) -> Cover:
    return Cover(shape.X_AS[None, :3, 3], np.array([shape.size_m[0]]), 0.0, 0.0)


def _polytope(corners: FloatArray, protrusion_m: float) -> Cover:
    corners, thicker_m = _thickened(corners)
    hull = ConvexHull(corners)
    solid = _Solid(hull.equations[:, :3], -hull.equations[:, 3])
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    protrusion_m = max(protrusion_m, _FINEST * size)
    pieces, centres = _pieces(corners[hull.vertices], solid, protrusion_m)
    chosen, radii = _set_cover(pieces, centres, solid.depth(centres) + protrusion_m)
    residual_m = _ROUNDING * size
    return Cover(centres[chosen], radii, residual_m, float((radii - solid.depth(centres[chosen])).max()) + thicker_m)


def _thickened(corners: FloatArray) -> tuple[FloatArray, float]:
    """The corners of a solid, and 0; of a flat one those of a solid around it, and by how much this sticks out."""
    spread = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    if spread[2] > _FLAT * spread[0]:
        return corners, 0.0
    half = max(10.0 * _FLAT * float(spread[0]), 1e-9)
    cube = half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return (corners[:, None] + cube).reshape(-1, 3), half * np.sqrt(3.0)


def _pieces(points: FloatArray, solid: _Solid, protrusion_m: float) -> tuple[list[FloatArray], FloatArray]:
    """Corners (n, 3) of pieces that fill the solid, and the centre (k, 3) of a ball for each."""
    todo, pieces, centres = [points], [], []
    while todo:
        piece = todo.pop()
        centre, excess = _best_ball(piece, solid)
        spans = np.ptp(piece, axis=0)
        if excess <= protrusion_m or spans.max() <= _LEAST_PIECE * protrusion_m:
            pieces.append(piece)
            centres.append(centre)
        else:
            todo += _cut_in_two(piece, int(np.argmax(spans)))
    return pieces, np.array(centres)


def _best_ball(piece: FloatArray, solid: _Solid) -> tuple[FloatArray, float]:
    """The centre (3,) of a ball around `piece`, and by how much it sticks out of the solid, which is nearly the least.

    Reach less depth is a convex function of the centre; subgradient steps with a shrinking length descend it.
    """
    centre = 0.5 * (piece.min(axis=0) + piece.max(axis=0))
    step = 0.5 * float(np.linalg.norm(np.ptp(piece, axis=0)))
    best, least = centre, np.inf
    for _ in range(_STEPS):
        distances = centre - piece
        reach = np.sqrt(np.einsum("ij,ij->i", distances, distances))
        depth = solid.offsets - solid.normals @ centre
        far, near = int(np.argmax(reach)), int(np.argmin(depth))
        excess = float(reach[far] - depth[near])
        if excess < least:
            best, least = centre, excess
        slope = distances[far] / max(reach[far], 1e-300) + solid.normals[near]
        centre = centre - step * slope / max(float(np.linalg.norm(slope)), 1e-12)
        step *= 0.88
    return best, least


def _cut_in_two(piece: FloatArray, axis: int) -> list[FloatArray]:
    """The hull of `piece` cut across `axis` in the middle, as corners.

    Where lines from every corner below to every corner above meet the cut lie all corners of the cut face.
    """
    level = 0.5 * (piece[:, axis].min() + piece[:, axis].max())
    low, high = piece[piece[:, axis] <= level], piece[piece[:, axis] >= level]
    share = (level - low[:, axis])[:, None] / np.maximum(high[:, axis] - low[:, axis, None], 1e-300)
    crossings = (low[:, None] + share[:, :, None] * (high - low[:, None])).reshape(-1, 3)
    crossings[:, axis] = level
    cut = crossings[_outline(np.delete(crossings, axis, axis=1))]
    return [np.concatenate([half[half[:, axis] != level], cut]) for half in (low, high)]


def _outline(points: FloatArray) -> IntArray:
    """Indices of the corners of the hull of points in the plane; of all points where they span no area."""
    spans = np.ptp(points, axis=0)
    if spans.min() <= 1e-9 * spans.max() or len(points) < 4:
        return np.arange(len(points))
    return ConvexHull(points).vertices


def _set_cover(pieces: list[FloatArray], centres: FloatArray, radii: FloatArray) -> tuple[IntArray, FloatArray]:
    """Greedy set cover: which balls to keep so that each piece lies in one, and the radii (k,) that this takes.

    A ball may grow to `radii`; the one made for a piece holds it in any case.
    """
    first = np.cumsum([0, *(len(piece) for piece in pieces[:-1])])
    corners = np.concatenate(pieces)
    distances = np.sqrt(np.maximum(_squared(centres, corners), 0.0))
    reach = np.maximum.reduceat(distances, first, axis=1)
    holds = reach <= np.maximum(radii, np.diagonal(reach))[:, None]
    owner = np.full(len(pieces), -1)
    while (owner < 0).any():
        best = int(np.argmax(holds[:, owner < 0].sum(axis=1)))
        owner[(owner < 0) & holds[best]] = best
    owners = np.unique(owner)
    exact = [
        np.linalg.norm(np.concatenate([pieces[j] for j in np.flatnonzero(owner == k)]) - centres[k], axis=1).max()
        for k in owners
    ]
    return owners, np.array(exact)


def _squared(one: FloatArray, two: FloatArray) -> FloatArray:
    return np.sum(one**2, axis=1)[:, None] - 2.0 * one @ two.T + np.sum(two**2, axis=1)
