"""The bounded edits on one mesh, and what must be wrong before each is reported.

Artists' habits are not defects: open parts, parts that touch or interpenetrate, cards, back faces, seams, collapsed
quads, a few slivers. What is removed without harm is removed silently; the counts before and after are in the record.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from geom.components import components_of
from geom.duplicate_shells import has_reverse
from geom.edges import edges_of
from geom.mesh_edit import keep_faces, merge_surfaces
from geom.openings import OpenBody, Opening, judge_open_bodies
from geom.repair_faces import drop_fins, drop_surplus_faces, true_degenerates
from geom.repair_holes import fill_openings
from geom.repair_shells import drop_duplicate_shells
from geom.repair_vertices import split_bow_ties, touching_points
from geom.repair_winding import orient, outward_flips
from geom.surface_distance import closest_on_surface, triangle_areas
from geom.topology import repeats_point
from geom.weld import weld, weld_points
from schemas.model import FloatArray, IntArray, Mesh

Counts = Mapping[str, float]
Surface = tuple[FloatArray, IntArray]

# Fewer surplus faces than this share are what exporters leave behind, unless removing them closes a solid.
SURPLUS_SHARE = 5e-3
# Zero-area faces alone do no harm to a surface; above this share the export went wrong.
DEGENERATE_SHARE = 0.05
FLIPPED_SHARE = 2e-3
# A loop this thin (area over squared perimeter; a circle has 0.08) is a T-junction, not a hole.
CRACK_THINNESS = 2e-3
# An eye in its socket, a dial in its housing: gap between the rim and the other part, over the hole's mean radius.
FITTED_GAP = 0.1


@dataclass(frozen=True)
class Item:
    """One mesh on its way through the edits, and all meshes at this point, of which it is number `index`."""

    source: Mesh
    index: int
    meshes: Sequence[Mesh]

    @property
    def mesh(self) -> Mesh:
        """The mesh as edited so far."""
        return self.meshes[self.index]

    @property
    def others(self) -> Surface:
        """The surface of the other meshes."""
        points, triangles, _ = merge_surfaces([m for i, m in enumerate(self.meshes) if i != self.index])
        return points, triangles


@dataclass(frozen=True)
class Edit:
    """An edited mesh; `before` and `after` are None when nothing was wrong enough to be reported."""

    mesh: Mesh
    before: Counts | None = None
    after: Counts = field(default_factory=dict[str, float])


def _surplus_faces(item: Item) -> Edit:
    """Degenerate and duplicate faces. Reported when their removal closes a solid or they are many."""
    mended, figures = drop_surplus_faces(item.mesh)
    if len(mended.triangles) == 0:
        return Edit(item.mesh)
    degenerate, duplicate = int(figures["degenerate_faces"]), int(figures["duplicate_faces"])
    faces = len(item.mesh.triangles)
    wrong = (duplicate > 0 and _open_faces(mended) < _open_faces(item.mesh)) or (
        duplicate >= SURPLUS_SHARE * faces or true_degenerates(item.source) >= DEGENERATE_SHARE * faces
    )
    if degenerate + duplicate == 0 or not wrong:
        return Edit(mended)
    return Edit(
        mended,
        {"surplus_faces": degenerate + duplicate, "degenerate_faces": degenerate, "duplicate_faces": duplicate},
        {"surplus_faces": 0, "degenerate_faces": 0, "duplicate_faces": 0},
    )


def _duplicate_shells(item: Item) -> Edit:
    """Copies of closed shells, always reported: volume and mass would count them."""
    mended, figures = drop_duplicate_shells(item.mesh)
    if not figures["shells"]:
        return Edit(item.mesh)
    before = {"duplicate_shells": figures["shells"], "triangles": len(item.mesh.triangles)}
    return Edit(mended, before, {"duplicate_shells": 0, "triangles": len(mended.triangles)})


def _winding(item: Item) -> Edit:
    """Solids wound inside out or inconsistently. Reported from 0.2 % of the faces on."""
    mended, figures = orient(item.mesh, _backed_elsewhere(item))
    flipped = int(figures["flipped_faces"])
    if flipped < FLIPPED_SHARE * len(item.mesh.triangles) or flipped == 0:
        return Edit(mended)
    return Edit(mended, {"misoriented_faces": flipped}, {"misoriented_faces": 0})


def _fins(item: Item) -> Edit:
    """Small sheets hanging on an otherwise closed solid."""
    mended, figures = drop_fins(item.mesh)
    if not figures["fin_faces"]:
        return Edit(item.mesh)
    crowded = [int((edges_of(m.triangles).uses > 2).sum()) for m in (item.mesh, mended)]
    return Edit(
        mended,
        {"fin_faces": figures["fin_faces"], "non_manifold_edges": crowded[0]},
        {"fin_faces": 0, "non_manifold_edges": crowded[1]},
    )


def _bow_ties(item: Item) -> Edit:
    """Solids that touch in a point alone; every fan then gets its own point."""
    touching = touching_points(item.mesh.points, item.mesh.triangles)
    if touching.size == 0:
        return Edit(item.mesh)
    split, _ = split_bow_ties(item.mesh, touching)
    return Edit(weld(split), {"non_manifold_vertices": len(touching)}, {"non_manifold_vertices": 0})


def _holes(item: Item) -> Edit:
    """Holes in nearly closed surfaces, except T-junction cracks and holes that another part is fitted into."""
    mesh = item.mesh
    edges = edges_of(mesh.triangles)
    parts = components_of(mesh.points, mesh.triangles, edges)
    bodies = judge_open_bodies(mesh.points, mesh.triangles, edges, parts)
    holes = [o for b in bodies if b.kind == "holes" for o in _true_holes(b, item)]
    if not holes:
        return Edit(mesh)
    filled, figures = fill_openings(mesh, holes)
    looped = sum(len(o.points) for o in holes)
    boundary = int((edges.uses == 1).sum())
    return Edit(
        weld(filled),
        {"holes": len(holes), "boundary_edges": boundary, "filled_area_m2": 0.0},
        {"holes": 0, "boundary_edges": boundary - looped, "filled_area_m2": figures["filled_area"]},
    )


def _open_faces(mesh: Mesh) -> int:
    """Faces that belong to components with an edge of an odd number of faces."""
    proper = mesh.triangles[~repeats_point(mesh.triangles)]
    parts = components_of(mesh.points, proper)
    return int(parts.faces[~parts.closed].sum())


def _true_holes(body: OpenBody, item: Item) -> list[Opening]:
    others = np.ones(len(item.mesh.triangles), dtype=bool)
    others[body.faces] = False
    rest = keep_faces(item.mesh, others)
    surfaces = [(rest.points, rest.triangles), item.others]
    around = [(p, t) for p, t in surfaces if len(t) and triangle_areas(p[t]).any()]
    return [o for o in body.openings if not _is_crack(o, item.mesh) and not _is_fitted(o, item.mesh, around)]


def _is_crack(opening: Opening, mesh: Mesh) -> bool:
    rim = mesh.points[opening.points]
    perimeter = float(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1).sum())
    return opening.area < CRACK_THINNESS * perimeter**2


def _is_fitted(opening: Opening, mesh: Mesh, around: Sequence[Surface]) -> bool:
    """True iff another part is fitted into the hole: half of the rim lies within a tenth of its radius of that part."""
    rim = mesh.points[opening.points]
    reach = FITTED_GAP * float(np.sqrt(opening.area / np.pi))
    gaps = [np.linalg.norm(closest_on_surface(rim, p, t)[0] - rim, axis=1) for p, t in around]
    return any(float(np.median(gap)) <= reach for gap in gaps)


def _backed_elsewhere(item: Item) -> FloatArray | None:
    """(m,) True for faces that another mesh shows from behind; None when there is no other mesh.

    Such a mesh is the inside of a double-sided drawing, not an inverted solid.
    """
    if len(item.meshes) == 1 or not outward_flips(item.mesh.points, item.mesh.triangles).any():
        return None
    points, triangles, owner = merge_surfaces(item.meshes)
    return has_reverse(weld_points(points, triangles)[1])[owner == item.index]


# The order matters: a shell's copies are also duplicate faces, surplus faces hide edges, holes need winding.
EDITS: tuple[tuple[str, str, str, Callable[[Item], Edit]], ...] = (
    ("duplicate_shell", "asset/duplicate-shell", "copies of a closed surface were removed", _duplicate_shells),
    ("degenerate_faces", "asset/degenerate-faces", "faces without area or present twice were removed", _surplus_faces),
    ("flip_winding", "asset/inverted-winding", "faces wound the wrong way were turned", _winding),
    ("non_manifold_edge", "asset/non-manifold-edge", "surplus faces on a solid's edges were removed", _fins),
    ("non_manifold_vertex", "asset/non-manifold-vertex", "points where solids touch were split", _bow_ties),
    ("hole_fill", "asset/small-holes", "holes in a nearly closed surface were filled", _holes),
)
