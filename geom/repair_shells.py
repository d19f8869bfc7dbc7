"""Drop copies of closed shells and stray fragments."""

from __future__ import annotations

from geom.components import components_of
from geom.duplicate_shells import surplus_shells
from geom.mesh_edit import keep_faces
from geom.topology import fragments
from geom.weld import diagonal
from schemas.model import Mesh

Figures = dict[str, float | int | str]


def drop_duplicate_shells(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) with one copy of each closed shell. Figures: `shells` removed."""
    parts = components_of(mesh.points, mesh.triangles)
    count, surplus = surplus_shells(mesh.points, mesh.triangles, parts)
    return keep_faces(mesh, ~surplus), {"shells": count}


def drop_fragments(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) without open components of < 0.1 % area and < 2 % extent.

    Closed ones are small parts (screws, buttons) and stay. Figures: `fragments` removed.
    """
    parts = components_of(mesh.points, mesh.triangles)
    stray = fragments(parts, diagonal(mesh.points)) & ~parts.closed
    return keep_faces(mesh, ~stray[parts.label]), {"fragments": int(stray.sum())}
