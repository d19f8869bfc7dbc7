"""Removal of duplicate closed shells and of stray open fragments of a `Mesh`."""

from __future__ import annotations

import numpy as np

from geom.mesh.components import components_of
from geom.mesh.duplicate_shells import surplus_shells
from geom.mesh.edit import keep_faces
from geom.mesh.topology import fragments, repeats_point
from geom.mesh.weld import diagonal
from schemas.model import Mesh

Figures = dict[str, float]
STRAY_AREA_SHARE = 0.01


def drop_duplicate_shells(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded) with one copy of each closed shell. Figures: `shells` removed."""
    proper = np.flatnonzero(~repeats_point(mesh.triangles))
    parts = components_of(mesh.points, mesh.triangles[proper])
    count, surplus = surplus_shells(mesh.points, mesh.triangles[proper], parts)
    remains = np.ones(len(mesh.triangles), dtype=bool)
    remains[proper[surplus]] = False
    return keep_faces(mesh, remains), {"shells": count}


def drop_fragments(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) without open components of < 0.1 % area and < 2 % extent.

    Closed ones are small parts (screws, buttons) and stay; so do all when together they exceed 1 % of the area,
    because then the surface is made of patches. Figures: `fragments` removed.
    """
    parts = components_of(mesh.points, mesh.triangles)
    stray = fragments(parts, diagonal(mesh.points)) & ~parts.closed
    if parts.area[stray].sum() > STRAY_AREA_SHARE * parts.area.sum():
        return mesh, {"fragments": 0}
    return keep_faces(mesh, ~stray[parts.label]), {"fragments": int(stray.sum())}
