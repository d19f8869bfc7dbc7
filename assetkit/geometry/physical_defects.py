"""Defects of the mended meshes that change only the physical surface: overlaps, self-intersections, open shells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geom.mesh.edges import edges_of
from geom.mesh.manifold_arrays import signed_volume
from geom.mesh.topology import repeats_point
from geom.solid.closed_bodies import Bodies, Surface, unite
from geom.solid.self_intersections import SelfIntersection
from geom.solid.solidify import core_of
from schemas.model import Mesh

Counts = Mapping[str, float]

# Naive over united volume.
OVERLAP_BOUND = 1.02
# The asset is an open shell when containers carry this share of its area.
SHELL_SHARE = 0.98
# Edges with an odd number of faces, three or more, that are left after the edits; as a share of all edges.
DIRTY_SHARE = 5e-3


@dataclass(frozen=True)
class PhysicalDefect:
    """A defect that the physical surface answers: repair name, diagnostic code, headline, figures before and after."""

    name: str
    code: str
    headline: str
    before: Counts
    after: Counts


def find_physical_defects(
    meshes: Sequence[Mesh], bodies: Bodies, crossings: Sequence[SelfIntersection], surplus_found: bool
) -> tuple[PhysicalDefect, ...]:
    """Overlapping bodies, bodies that pass through themselves, open containers and meshes beyond single edits.

    In this order, each only where found; `bodies` and `crossings` are those of the meshes (`resolve_bodies`).

    `surplus_found`: degenerate or duplicate faces were reported; a mesh is beyond repair when crowded edges
    remain on top of that. Crowded edges alone are boards that meet by design.
    """
    defects = (
        _overlapping(meshes, bodies),
        _crossing(crossings),
        _open_shell(bodies),
        _dirty(meshes) if surplus_found else None,
    )
    return tuple(judgement for judgement in defects if judgement is not None)


def _overlapping(meshes: Sequence[Mesh], bodies: Bodies) -> PhysicalDefect | None:
    """What overlaps counts once. Where a part lies wholly inside another, `cavity_reading_m3` is what that may hide."""
    naive, united = _overlap(bodies)
    if not naive > OVERLAP_BOUND * united > 0.0:
        return None
    core = core_of(meshes, bodies)
    if core is None:
        headline, other = "closed parts of one mesh overlap", {}
    else:
        headline = "a closed part lies inside another one, wound alike: filled, or a cavity that lost its winding?"
        other = {"cavity_reading_m3": united - core.volume_m3}
    return PhysicalDefect(
        "self_intersection",
        "asset/overlapping-bodies",
        headline,
        {"volume_m3": naive, **other},
        {"volume_m3": united, **other},
    )


def _crossing(crossings: Sequence[SelfIntersection]) -> PhysicalDefect | None:
    resolved = [(c, c.resolved) for c in crossings if c.resolved is not None]
    if not resolved:
        return None
    return PhysicalDefect(
        "self_intersection",
        "asset/self-intersection",
        "a closed surface passes through itself",
        {
            "volume_m3": sum(signed_volume(*c.body) for c, _ in resolved),
            "intersecting_faces": sum(r.crossing_before for _, r in resolved),
            "largest_miscounted_share": max(c.miscounted_share for c, _ in resolved),
        },
        {
            "volume_m3": sum(signed_volume(*r.surface) for _, r in resolved),
            "intersecting_faces": sum(r.crossing_after for _, r in resolved),
            "largest_miscounted_share": 0.0,
        },
    )


def _open_shell(bodies: Bodies) -> PhysicalDefect | None:
    containers = [v for v in bodies.open_bodies if v.kind == "container"]
    area = sum(v.area for v in containers)
    if area < SHELL_SHARE * (bodies.closed_area + bodies.open_area) or area == 0.0:
        return None
    openings = {"openings": sum(len(v.openings) for v in containers)}
    headline = "an open container without wall thickness is kept open"
    return PhysicalDefect("open_shell_keep_cavity", "asset/open-shell", headline, openings, openings)


def _dirty(meshes: Sequence[Mesh]) -> PhysicalDefect | None:
    odd = sum(_odd_edges(m) for m in meshes)
    if odd <= DIRTY_SHARE * 1.5 * sum(len(m.triangles) for m in meshes):  # A closed mesh has 1.5 edges per face.
        return None
    headline = "the surface is too damaged for single edits; only the physical surface is rebuilt"
    return PhysicalDefect("mesh_repair", "asset/dirty-mesh", headline, {"odd_edges": odd}, {"odd_edges": odd})


def _overlap(sorted_bodies: Bodies) -> tuple[float, float]:
    """Added and united volume of the bodies of those meshes that consist of several closed bodies and nothing open.

    Overlap between meshes is how artists assemble; overlap inside one mesh counts the shared volume twice.
    """
    naive = united = 0.0
    for bodies in sorted_bodies.by_mesh:
        if len(bodies) < 2 or not _boxes_overlap(bodies):
            continue
        union = unite(bodies)
        if union is not None:
            naive += sum(signed_volume(*body) for body in bodies)
            united += signed_volume(*union)
    return naive, united


def _boxes_overlap(bodies: Sequence[Surface]) -> bool:
    low = np.array([points.min(axis=0) for points, _ in bodies])
    high = np.array([points.max(axis=0) for points, _ in bodies])
    order = np.argsort(low[:, 0], kind="stable")
    low, high = low[order], high[order]
    ends = np.searchsorted(low[:, 0], high[:, 0])  # Boxes from there on begin behind the end of this one.
    return any(
        bool(((low[i + 1 : end] < high[i]) & (high[i + 1 : end] > low[i])).all(axis=1).any())
        for i, end in enumerate(ends)
    )


def _odd_edges(mesh: Mesh) -> int:
    uses = edges_of(mesh.triangles[~repeats_point(mesh.triangles)]).uses
    return int(((uses > 2) & (uses % 2 == 1)).sum())
