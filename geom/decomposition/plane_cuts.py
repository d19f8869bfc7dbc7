"""Convex decomposition by plane cuts (unit size): each cut removes the most empty volume from the hulls.

A volume objective over half spaces, as in Thul, Ladický, Jeong and Pollefeys 2018 ("Approximate convex decomposition
and transfer for animated meshes"), with the planes at reflex edges among the candidates (Chazelle 1984, "Convex
partitions of polyhedra"): a table falls into board and legs in one cut. Pieces lie in disjoint cells, so the
hulls of a container's wall never reach into its opening.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from manifold3d import Manifold
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from geom.decomposition.candidate_planes import STEPS, candidate_planes
from geom.mesh.manifold_arrays import manifold_arrays
from schemas.arrays import BoolArray, FloatArray, IntArray

# A cut that lowers the balanced excess by less than this share is not worth a hull.
LEAST_GAIN = 0.02
REFINEMENTS = 3
CRUMB_SHARE = 1e-7
# Points this close to a plane (unit size) lie on it.
ON_PLANE = 1e-9


@dataclass(frozen=True, eq=False)
class Piece:
    """A closed body in one cell of the cuts, and its convex hull."""

    body: Manifold
    hull: Manifold

    @cached_property
    def excess(self) -> float:
        """Empty volume inside the hull."""
        return max(self.hull.volume() - self.body.volume(), 0.0)

    @cached_property
    def surface(self) -> tuple[FloatArray, IntArray]:
        """Points and triangles."""
        return manifold_arrays(self.body)

    @cached_property
    def edges(self) -> tuple[IntArray, IntArray]:
        """Point pairs (e, 2), each edge once, and the two faces (e, 2) at each; the surface is a manifold."""
        points, triangles = self.surface
        half = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        order = np.argsort(half[:, 0] * len(points) + half[:, 1], kind="stable")
        return half[order][::2], (order // 3).reshape(-1, 2)

    @cached_property
    def neighbours(self) -> tuple[IntArray, IntArray, IntArray]:
        """Both directions of every edge, sorted by start point: start, end, number of the edge."""
        edges = self.edges[0]
        both = np.concatenate([edges, edges[:, ::-1]])
        order = np.argsort(both[:, 0], kind="stable")
        return both[order, 0], both[order, 1].astype(np.int32), np.tile(np.arange(len(edges)), 2)[order]


@dataclass(frozen=True)
class CutGoal:
    """When to stop cutting.

    slack       all excess together, as a share of the volume.
    balance     power, above 1, of each excess in the sum that a cut lowers, which favours many small ones over one
                large: halving a cup gains nothing yet, but quartering it does.
    most        pieces; joining neighbours afterwards is cheap.
    violation   of other requirements by a hull, above 0 where violated (worst first): excess, a closed opening.
    """

    slack: float
    most: int
    violation: Callable[[Manifold], float]
    balance: float = 1.25


def cut_apart(seeds: Sequence[Manifold], goal: CutGoal) -> list[Piece]:
    """Nearly convex pieces that fill the bodies `seeds` (unit size), crumbs (`CRUMB_SHARE`) excepted. Deterministic."""
    total = sum(seed.volume() for seed in seeds)
    worst: Piece
    open_: list[Piece] = _pieces(seeds, CRUMB_SHARE * total)
    done: list[Piece] = []
    violations: dict[Piece, float] = {}
    while open_ and len(open_) + len(done) < goal.most:
        if sum(p.excess for p in [*open_, *done]) > goal.slack * total:
            worst = max(open_, key=lambda p: p.excess)
        else:
            violations |= {p: goal.violation(p.hull) for p in open_ if p not in violations}
            worst = max(open_, key=lambda p: violations[p])
            if violations[worst] <= 0.0:
                break
        open_ = [p for p in open_ if p is not worst]
        plane = best_cut(worst, goal.balance) if worst.excess > CRUMB_SHARE * total else None
        if plane is None:
            done.append(worst)
            continue
        halves = worst.body.split_by_plane((plane[0][0], plane[0][1], plane[0][2]), plane[1])
        open_ += _pieces([part for half in halves for part in half.decompose()], CRUMB_SHARE * total)
    return done + open_


def cut_sectors(body: Manifold, axis: FloatArray, place: FloatArray, planes: int) -> list[Manifold]:
    """Connected pieces of `body` between `planes` even planes through the line along `axis` (3,) through `place` (3,).

    A ring must be cut into several pieces before their hulls leave its hole open: with eight, 92 % of its radius.
    """
    u, v = np.linalg.svd(axis[None])[2][1:]
    parts = [body]
    for angle in np.pi * np.arange(planes) / planes:
        normal = np.cos(angle) * u + np.sin(angle) * v
        parts = [h for part in parts for h in part.split_by_plane((normal[0], normal[1], normal[2]), normal @ place)]
    return [piece for part in parts for piece in part.decompose()]


def _pieces(bodies: Sequence[Manifold], crumb: float) -> list[Piece]:
    pieces = [Piece(body, body.hull()) for body in bodies if body.volume() > crumb]
    return [piece for piece in pieces if piece.hull.volume() > 0.0]


def best_cut(piece: Piece, balance: float) -> tuple[FloatArray, float] | None:
    """Normal (3,) and offset of the plane with the least balanced excess behind it; None when no plane helps.

    The best candidate is then moved along its normal, three times by half the step before.
    """
    points, triangles = piece.surface
    planes = candidate_planes(points, triangles, *piece.edges, manifold_arrays(piece.hull)[0])
    best = min(
        ((_cost(piece, n, d, balance), k) for k, (n, d) in enumerate(zip(*planes, strict=True))), default=(np.inf, 0)
    )
    if not best[0] < (1.0 - LEAST_GAIN) * piece.excess**balance:
        return None
    least, normal, offset = best[0], planes[0][best[1]], float(planes[1][best[1]])
    step = float(np.ptp(points @ normal)) / (STEPS + 1)
    for _ in range(REFINEMENTS):
        step *= 0.5
        moved = min((_cost(piece, normal, offset + s, balance), s) for s in (-step, step))
        if moved[0] < least:
            least, offset = moved[0], offset + moved[1]
    return normal, offset


def _cost(piece: Piece, normal: FloatArray, offset: float, balance: float) -> float:
    excess = excess_after(piece, normal, offset)
    return float((excess**balance).sum()) if len(excess) else np.inf


def excess_after(piece: Piece, normal: FloatArray, offset: float) -> FloatArray:
    """Hull volume beyond the body's, of each part (k,) that a cut leaves; empty when the plane misses the piece.

    The body is not cut: the hull of a part is that of its points and those on the cut edges, and its volume is the sum
    of cones from a point of the plane, to which the cut faces add nothing. A tube cut across leaves its inner
    surface as a part of negative volume, which belongs to the part whose box is around it (an estimate, good to 1 %).
    """
    points, triangles = piece.surface
    local = points - offset * normal
    height = local @ normal
    height[np.abs(height) < ON_PLANE] = 0.0
    above = height > 0.0
    if not above.any() or above.all():
        return np.empty(0)
    edges = piece.edges[0]
    is_cut = above.take(edges[:, 0]) != above.take(edges[:, 1])
    start, end, edge = piece.neighbours
    stays = ~is_cut.take(edge)
    rows = np.zeros(len(points) + 1, dtype=np.int32)
    np.cumsum(np.bincount(start.compress(stays), minlength=len(points)), out=rows[1:])
    graph = csr_array((np.ones(int(rows[-1])), end.compress(stays), rows), shape=(len(points), len(points)))
    count, part = connected_components(graph, directed=True, connection="strong")  # The graph is symmetric.
    a, b = edges.compress(is_cut, axis=0).T
    at_a, at_b = _rows(local, a), _rows(local, b)
    height_a = _rows(height, a)
    crossing: FloatArray = at_a + (height_a / (height_a - _rows(height, b)))[:, None] * (at_b - at_a)
    volumes = _volumes(local, height, triangles, above, part, count)
    corners = np.concatenate([local, crossing, crossing])
    owner: IntArray = np.concatenate([part, part[a], part[b]])
    order = np.argsort(owner, kind="stable")
    corners: FloatArray = corners.take(order, axis=0)
    ends = np.cumsum(np.bincount(owner, minlength=count)).tolist()
    groups = [corners[first:end] for first, end in zip([0, *ends], ends, strict=False)]
    if (volumes < -ON_PLANE).any():
        side = np.zeros(count, dtype=bool)
        side[part] = above
        groups, volumes = _with_inner_surfaces(groups, volumes, side)
    hulls = np.array([Manifold.hull_points(g).volume() if len(g) > 3 else 0.0 for g in groups])
    return np.maximum(hulls - np.maximum(volumes, 0.0), 0.0)


def _rows(values: FloatArray, which: IntArray) -> FloatArray:
    """Rows of an array by number."""
    return values.take(which, axis=0)


def _volumes(
    local: FloatArray, height: FloatArray, triangles: IntArray, above: BoolArray, part: IntArray, count: int
) -> FloatArray:
    """Volume (k,) of the cones from the origin, on the plane, to the faces of each part, cut faces shared out."""
    over = above.take(triangles)
    first, second, third = over.T
    is_shared = (first != second) | (second != third)
    a, b, c = triangles.compress(~is_shared, axis=0).T
    total = np.zeros(count)
    at_a, at_b, at_c = _rows(local, a), _rows(local, b), _rows(local, c)
    total += np.bincount(part[a], _cone(at_a, at_b, at_c), count)
    shared, over = triangles.compress(is_shared, axis=0), over.compress(is_shared, axis=0)
    # The corner that is alone on its side: the one unlike both others.
    one_above: BoolArray = over.sum(axis=1) == 1
    alone = cast(IntArray, np.where(one_above, over.argmax(axis=1), (~over).argmax(axis=1)))
    row = np.arange(len(shared))
    a, b, c = (shared[row, (alone + k) % 3] for k in range(3))
    at_a, at_b, at_c = (local.take(corner, axis=0) for corner in (a, b, c))
    height_a = height.take(a)
    to_b = at_a + (height_a / (height_a - height.take(b)))[:, None] * (at_b - at_a)
    to_c = at_a + (height_a / (height_a - height.take(c)))[:, None] * (at_c - at_a)
    total += np.bincount(part[a], _cone(at_a, to_b, to_c), count)
    total += np.bincount(part.take(b), _cone(to_b, at_b, at_c) + _cone(to_b, at_c, to_c), count)
    return total


def _cone(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Signed volumes (m,) of the tetrahedra between the origin and triangles, given corner by corner (m, 3)."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (np.ascontiguousarray(corner.T) for corner in (a, b, c))
    return (ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)) / 6.0


def _with_inner_surfaces(
    groups: list[FloatArray], volumes: FloatArray, side: BoolArray
) -> tuple[list[FloatArray], FloatArray]:
    """The parts with those of negative volume joined to the smallest enclosing part on the same side."""
    volumes, remains = volumes.copy(), np.ones(len(groups), dtype=bool)
    low, high = np.array([g.min(axis=0) for g in groups]), np.array([g.max(axis=0) for g in groups])
    for k in np.flatnonzero(volumes < -ON_PLANE):
        around = (low <= low[k] + ON_PLANE).all(axis=1) & (high >= high[k] - ON_PLANE).all(axis=1)
        around &= (volumes > 0.0) & (side == side[k])
        if around.any():
            holder = np.flatnonzero(around)[np.prod(high - low, axis=1)[around].argmin()]
            volumes[holder] += volumes[k]
            remains[k] = False
    return [g for g, stays in zip(groups, remains, strict=True) if stays], volumes[remains]
