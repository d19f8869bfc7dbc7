"""Replace closed bodies that pass through themselves by what they enclose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from geom.mesh.surface_distance import triangle_areas
from geom.repair.self_overlap import self_overlap
from geom.solid.closed_bodies import Bodies, Surface, as_manifold
from schemas.model import FloatArray, IntArray

# Of the enclosed volume; clean meshes have none, the grid of rays sees no less.
MISCOUNTED_SHARE = 1e-3
# Smaller bodies weigh too little to be looked at; this also bounds their number.
LEAST_AREA_SHARE = 0.01


@dataclass(frozen=True)
class Resolved:
    """A surface that no longer passes through itself, and how many faces cross others before and after."""

    surface: Surface
    crossing_before: int
    crossing_after: int


@dataclass(frozen=True)
class SelfCrossing:
    """A closed body that passes through itself; `resolved` is None when that could not be mended.

    miscounted_share  of its enclosed volume, counted double or negative; see `geom.repair.self_overlap`.
    """

    body: Surface
    miscounted_share: float
    resolved: Resolved | None


Resolver = Callable[[FloatArray, IntArray], Resolved | None]


def resolve_bodies(bodies: Bodies, resolver: Resolver) -> tuple[Bodies, tuple[SelfCrossing, ...]]:
    """`bodies` in which those that pass through themselves are replaced by what `resolver` makes of them.

    A body counts when it has 1 % of the area and more than 0.1 % of its volume is counted wrong. A result is taken when
    it is a closed oriented manifold that no longer does; otherwise the body stays and is named as unresolved.
    """
    areas = [float(triangle_areas(points[triangles]).sum()) for points, triangles in bodies.closed]
    least = LEAST_AREA_SHARE * sum(areas)
    found: list[SelfCrossing] = []
    mended: dict[int, Surface] = {}
    for body, area in zip(bodies.closed, areas, strict=True):
        if area < least or (share := self_overlap(*body).share) <= MISCOUNTED_SHARE:
            continue
        made = resolver(*body)
        if made is not None and not _is_sound(made.surface):
            made = None
        if made is not None:
            mended[id(body)] = made.surface
        found.append(SelfCrossing(body, share, made))
    if not mended:
        return bodies, tuple(found)
    closed = tuple(mended.get(id(body), body) for body in bodies.closed)
    by_mesh = tuple(tuple(mended.get(id(body), body) for body in mesh) for mesh in bodies.by_mesh)
    return replace(bodies, closed=closed, by_mesh=by_mesh), tuple(found)


def _is_sound(surface: Surface) -> bool:
    made = as_manifold(*surface)
    return not made.is_empty() and made.volume() > 0.0 and self_overlap(*surface).share <= MISCOUNTED_SHARE
