"""Detection of closed bodies that intersect themselves, and their replacement by the surface of what they enclose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from geom.mesh.surface_distance import triangle_areas
from geom.repair.self_overlap import self_overlap
from geom.solid.closed_bodies import Bodies, Surface, as_manifold
from schemas.arrays import FloatArray, IntArray

# Share of the enclosed volume; clean meshes have 0, and the grid of rays resolves no less.
MISCOUNTED_SHARE = 1e-3
# Smaller bodies have too little mass to be examined; this also bounds their number.
LEAST_AREA_SHARE = 0.01


@dataclass(frozen=True)
class Resolved:
    """A surface without self-intersections, and the number of crossing faces before and after."""

    surface: Surface
    crossing_before: int
    crossing_after: int


@dataclass(frozen=True)
class SelfIntersection:
    """A closed body that intersects itself; `resolved` is None when that could not be repaired.

    miscounted_share  of its enclosed volume, counted double or negative; see `geom.repair.self_overlap`.
    """

    body: Surface
    miscounted_share: float
    resolved: Resolved | None


Resolver = Callable[[FloatArray, IntArray], Resolved | None]


def resolve_bodies(bodies: Bodies, resolver: Resolver) -> tuple[Bodies, tuple[SelfIntersection, ...]]:
    """`bodies` in which those that intersect themselves are replaced by the result of `resolver`.

    A body counts when it has 1 % of the area and more than 0.1 % of its volume is miscounted. A result is used when it
    is a closed oriented manifold without self-intersections; else the body stays and is returned as unresolved.
    """
    areas = [float(triangle_areas(points[triangles]).sum()) for points, triangles in bodies.closed]
    least = LEAST_AREA_SHARE * sum(areas)
    crossings: list[SelfIntersection] = []
    mended: dict[int, Surface] = {}
    for body, area in zip(bodies.closed, areas, strict=True):
        if area < least or (share := self_overlap(*body).share) <= MISCOUNTED_SHARE:
            continue
        resolved = resolver(*body)
        if resolved is not None and not _is_sound(resolved.surface):
            resolved = None
        if resolved is not None:
            mended[id(body)] = resolved.surface
        crossings.append(SelfIntersection(body, share, resolved))
    if not mended:
        return bodies, tuple(crossings)
    closed = tuple(mended.get(id(body), body) for body in bodies.closed)
    by_mesh = tuple(tuple(mended.get(id(body), body) for body in mesh) for mesh in bodies.by_mesh)
    return replace(bodies, closed=closed, by_mesh=by_mesh), tuple(crossings)


def _is_sound(surface: Surface) -> bool:
    solid = as_manifold(*surface)
    return not solid.is_empty() and solid.volume() > 0.0 and self_overlap(*surface).share <= MISCOUNTED_SHARE
