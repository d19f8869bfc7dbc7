"""Fidelity of collision shapes to a solid (metres): volume ratio, two-way surface distance, openings that stay open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold, OpType

from geom.convex.hull import contains, convex_hull, volume
from geom.convex.support_function import surface
from geom.features.cavities import Cavity, keeps_cavity
from geom.features.leaks import leaks
from geom.mesh.components import components_of
from geom.mesh.surface_distance import closest_on_surface, sample_surface
from geom.mesh.weld import diagonal
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.physics import CollisionShape, Fidelity, Solid

FIDELITY_SAMPLES = 4000
# Hulls that share a cut plane leave a slit of rounding width between them, whose walls are no outer surface. Grown by
# this share of the diagonal they merge; the distances below are too large by at most 1.7 times that.
SLIT_GROWTH_SHARE = 5e-4
# A gap that lets a ball through is wider than this share of its radius at the middle.
GAP_RADIUS_SHARE = 0.7
# Far more than rounding, as a share of the size of a hull.
BOX_SLACK = 1e-6
_CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@dataclass(frozen=True)
class ReferenceSurface:
    """The outer surface of a solid, with samples, against which collision shapes are measured.

    points (n, 3), triangles (m, 3)  without the walls of sealed inner cavities, which touch nothing.
    probes                           (k, 3) points spread over it, `samples` of them evenly, then corners.
    size                             diagonal of its box.
    volume_m3                        None unless the solid is closed.
    """

    points: FloatArray
    triangles: IntArray
    probes: FloatArray
    samples: int
    size: float
    volume_m3: float | None


def reference_surface(solid: Solid, samples: int = FIDELITY_SAMPLES) -> ReferenceSurface:
    """The outer surface of `solid` with its probes. Deterministic."""
    outer = outer_surface(solid)
    inside = volume(*outer) if solid.kind == "closed" else None
    return ReferenceSurface(*outer, _probes(*outer, samples), samples, diagonal(outer[0]), inside)


def measure_fidelity(
    method: str, shapes: Sequence[CollisionShape], against: Solid | ReferenceSurface, cavities: Sequence[Cavity]
) -> Fidelity:
    """Figures of `shapes` against a solid, not yet accepted; see `schemas.physics.Fidelity`.

    `outside`: from the outer surface of the union of all shapes to the outer surface of the solid; a lid over an
    opening counts here. `missing`: from the solid's surface to the union, 0 for points inside it: creases and parts
    within parts cannot be touched. `volume_ratio` is None unless the solid is closed. A container is not kept either
    when a ball in it gets out through a gap. Deterministic. Raises ValueError for no shapes.
    """
    if not shapes:
        raise ValueError("no shapes to measure")
    target = against if isinstance(against, ReferenceSurface) else reference_surface(against)
    union = union_surface(shapes, SLIT_GROWTH_SHARE * target.size)
    outside = _distances(_probes(*union, target.samples), target.points, target.triangles)
    missing = np.zeros(len(target.probes))
    uncovered = ~_within(shapes, target.probes)
    missing[uncovered] = _distances(target.probes[uncovered], *union)
    is_open = all(keeps_cavity(shapes, cavity) for cavity in cavities)
    all_kept = is_open and all(_holds_ball(union, target, cavity, float(missing.max())) for cavity in cavities)
    return Fidelity(
        method=method,
        shapes=len(shapes),
        vertices=sum(len(s.points) for s in shapes if s.points is not None),
        volume_ratio=union_volume(shapes) / target.volume_m3 if target.volume_m3 is not None else None,
        outside_p95=float(np.percentile(outside[: target.samples], 95)) / target.size,
        outside_max=float(outside.max()) / target.size,
        missing_p95=float(np.percentile(missing[: target.samples], 95)) / target.size,
        missing_max=float(missing.max()) / target.size,
        cavity_open=is_open if cavities else None,
        cavity_kept=all_kept if cavities else None,
        accepted=False,
    )


def _holds_ball(union: tuple[FloatArray, IntArray], target: ReferenceSurface, cavity: Cavity, gap_m: float) -> bool:
    """Whether a ball stays in the cavity of the shapes as in that of the solid; `gap_m`: largest distance between them.

    Where a ball gets out through a wall, that wall is about its radius away from the shapes.
    """
    if cavity.through or gap_m <= GAP_RADIUS_SHARE * cavity.probe_m:
        return True
    place = (cavity.way_m[-1], cavity.opening_m, cavity.direction, cavity.probe_m)
    return not leaks(*union, *place) or leaks(target.points, target.triangles, *place)


def outer_surface(solid: Solid) -> tuple[FloatArray, IntArray]:
    """Points and triangles of `solid` without the walls of sealed inner cavities."""
    if solid.kind != "closed":
        return solid.points, solid.triangles
    parts = components_of(solid.points, solid.triangles)
    triangles = solid.triangles[(parts.volume > 0.0)[parts.label]]
    if len(triangles) == 0:
        return solid.points, solid.triangles
    used, index = np.unique(triangles, return_inverse=True)
    return solid.points[used], index.reshape(-1, 3).astype(np.int32)


def union_volume(shapes: Sequence[CollisionShape]) -> float:
    """Volume of the union of the shapes in cubic metres; curved shapes are inscribed polyhedra."""
    return float(_union(shapes, 0.0).volume())


def union_surface(shapes: Sequence[CollisionShape], growth_m: float = 0.0) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) and triangles (m, 3) of the union of all shapes, each grown by a cube of half edge `growth_m`."""
    mesh = _union(shapes, growth_m).to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].astype(np.float64), np.asarray(mesh.tri_verts).astype(np.int32)


def _probes(points: FloatArray, triangles: IntArray, samples: int) -> FloatArray:
    """`samples` points spread over a surface, then its corners, at most as many."""
    corners = np.unique(triangles)
    corners = corners[:: max(1, -(-len(corners) // samples))]
    return np.concatenate([sample_surface(points, triangles, samples, 0)[0], points[corners]])


def _distances(queries: FloatArray, points: FloatArray, triangles: IntArray) -> FloatArray:
    if len(queries) == 0:
        return np.zeros(0)
    return np.linalg.norm(queries - closest_on_surface(queries, points, triangles)[0], axis=1)


def _within(shapes: Sequence[CollisionShape], queries: FloatArray) -> BoolArray:
    """(k,) True where a query lies inside some shape."""
    inside = np.zeros(len(queries), dtype=bool)
    for shape in shapes:
        rest = ~inside
        if shape.kind == "hull":  # Only what lies in its box can lie in it.
            corners = surface(shape)[0]
            low, high = corners.min(axis=0), corners.max(axis=0)
            slack = BOX_SLACK * float((high - low).max())
            rest &= ((queries >= low - slack) & (queries <= high + slack)).all(axis=1)
        inside[rest] = _holds(shape, queries[rest])
    return inside


def _holds(shape: CollisionShape, queries: FloatArray) -> BoolArray:
    """(k,) True where a query lies inside one shape, whose curved faces count as round."""
    if shape.kind == "hull":
        return contains(*convex_hull(surface(shape)[0]), queries)
    local = np.abs((queries - shape.X_AS[:3, 3]) @ shape.X_AS[:3, :3])
    if shape.kind == "box":
        return np.all(local <= 0.5 * np.asarray(shape.size_m), axis=1)
    radius, half = shape.size_m[0], (0.5 * shape.size_m[1] if len(shape.size_m) > 1 else 0.0)
    across, along = np.hypot(local[:, 0], local[:, 1]), local[:, 2]
    if shape.kind == "cylinder":
        return (across <= radius) & (along <= half)
    return np.hypot(across, np.maximum(along - half, 0.0)) <= radius


def _union(shapes: Sequence[CollisionShape], growth_m: float) -> Manifold:
    solids: list[Manifold] = []
    for shape in shapes:
        points = surface(shape)[0]
        if growth_m > 0.0:
            points = (points[:, None, :] + growth_m * _CUBE).reshape(-1, 3)
        solids.append(Manifold.hull_points(np.ascontiguousarray(points, dtype=np.float64)))
    return Manifold.batch_boolean(solids, OpType.Add)
