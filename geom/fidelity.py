"""How well collision shapes stand for a solid: volume, two-way surface distance, and whether openings stay open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold, OpType

from geom.cavity import Cavity, keeps_cavity
from geom.components import components_of
from geom.hull import contains, convex_hull, volume
from geom.support import surface
from geom.surface_distance import closest_on_surface, sample_surface
from geom.weld import diagonal
from schemas.model import FloatArray, IntArray
from schemas.physics import CollisionShape, Fidelity, Solid

SAMPLES = 4000
# Hulls that share a cut plane leave a slit of rounding width between them, whose walls are no outer surface. Grown by
# this share of the diagonal they merge; the distances below are too large by at most 1.7 times that.
SLIT_SHARE = 5e-4
_CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def measure(
    method: str, shapes: Sequence[CollisionShape], solid: Solid, cavities: Sequence[Cavity], samples: int = SAMPLES
) -> Fidelity:
    """Figures of `shapes` against `solid`, not yet accepted; see `schemas.physics.Fidelity`.

    `outside`: from the outer surface of the union of all shapes to the outer surface of the solid (sealed inner
    cavities touch nothing); a lid over an opening shows here. `missing`: from the solid's surface to the union, 0 for
    what lies inside it: creases and parts within parts cannot be touched. `volume_ratio` is None unless the solid is
    closed, `cavity_kept` when it has no cavity. Deterministic. Raises ValueError for no shapes.
    """
    if not shapes:
        raise ValueError("no shapes to measure")
    outer = outer_surface(solid)
    size = diagonal(outer[0])
    union = union_surface(shapes, SLIT_SHARE * size)
    outside = _distances(_probes(*union, samples), *outer)
    probes = _probes(*outer, samples)
    missing = np.where(_within(shapes, probes), 0.0, _distances(probes, *union))
    ratio = union_volume(shapes) / volume(*outer) if solid.kind == "closed" else None
    kept = all(keeps_cavity(shapes, cavity) for cavity in cavities) if cavities else None
    return Fidelity(
        method=method,
        shapes=len(shapes),
        vertices=sum(len(s.points) for s in shapes if s.points is not None),
        volume_ratio=ratio,
        outside_p95=float(np.percentile(outside[:samples], 95)) / size,
        outside_max=float(outside.max()) / size,
        missing_p95=float(np.percentile(missing[:samples], 95)) / size,
        missing_max=float(missing.max()) / size,
        cavity_kept=kept,
        accepted=False,
    )


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
    """`samples` points spread over a surface, then its corners, at most so many."""
    corners = np.unique(triangles)
    corners = corners[:: max(1, -(-len(corners) // samples))]
    return np.concatenate([sample_surface(points, triangles, samples, 0)[0], points[corners]])


def _distances(queries: FloatArray, points: FloatArray, triangles: IntArray) -> FloatArray:
    return np.linalg.norm(queries - closest_on_surface(queries, points, triangles)[0], axis=1)


def _within(shapes: Sequence[CollisionShape], queries: FloatArray) -> FloatArray:
    """(k,) True where a query lies inside some shape."""
    inside = np.zeros(len(queries), dtype=bool)
    for shape in shapes:
        inside |= contains(*convex_hull(surface(shape)[0]), queries)
    return inside


def _union(shapes: Sequence[CollisionShape], growth_m: float) -> Manifold:
    solids = []
    for shape in shapes:
        points = surface(shape)[0]
        if growth_m > 0.0:
            points = (points[:, None, :] + growth_m * _CUBE).reshape(-1, 3)
        solids.append(Manifold.hull_points(np.ascontiguousarray(points, dtype=np.float64)))
    return Manifold.batch_boolean(solids, OpType.Add)
