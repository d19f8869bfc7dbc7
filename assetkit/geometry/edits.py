"""The bounded edits on one mesh, and what must be wrong before each is reported.

Artists' habits are not defects: open parts, parts that touch or interpenetrate, cards, back faces, seams, collapsed
quads, a few slivers. What is removed without harm is removed silently; the counts before and after are in the record.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from assetkit.geometry.edit import Edit, EditContext
from assetkit.geometry.holes import fill_holes
from geom.mesh.components import components_of
from geom.mesh.duplicate_shells import has_reverse
from geom.mesh.edges import edges_of
from geom.mesh.edit import flip_faces, keep_faces, merge_surfaces, normal_cosines, turn_normals
from geom.mesh.hausdorff import one_sided_hausdorff
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.topology import repeats_point
from geom.mesh.weld import diagonal, weld, weld_points
from geom.repair.debris import loose_debris
from geom.repair.edges import split_touching_edges
from geom.repair.faces import drop_backs_of_solids, drop_fins, drop_surplus_faces, fin_faces, true_degenerates
from geom.repair.fill_uncertainty import ShapeUncertainty
from geom.repair.shape_change import EDIT_TOLERANCE_SHARE
from geom.repair.sheet_orientation import sheet_flips
from geom.repair.shells import drop_duplicate_shells
from geom.repair.t_junctions import stitch_t_junctions
from geom.repair.vertices import split_bow_ties, touching_points
from geom.repair.winding import orient, outward_flips
from schemas.arrays import BoolArray
from schemas.model import Mesh

# Fewer surplus faces than this share are what exporters leave behind, unless removing them closes a solid.
SURPLUS_SHARE = 5e-3
# Zero-area faces alone do no harm to a surface; above this share the export went wrong.
DEGENERATE_SHARE = 0.05
FLIPPED_SHARE = 2e-3
# Smooth shading bends normals; beyond a third of a turn they belong to the other side.
INWARD_COSINE = -0.5
MEANT_AREA_SHARE = 0.01
# Debris is less than 1 % of the area and touches nothing: without it the shape is the same.
NO_UNCERTAINTY = ShapeUncertainty(0.0, np.zeros(3))


def _surplus_faces(item: EditContext) -> Edit:
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


def _duplicate_shells(item: EditContext) -> Edit:
    """Copies of closed shells, always reported: volume and mass would count them."""
    mended, figures = drop_duplicate_shells(item.mesh)
    if not figures["shells"]:
        return Edit(item.mesh)
    before = {"duplicate_shells": figures["shells"], "triangles": len(item.mesh.triangles)}
    return Edit(mended, before, {"duplicate_shells": 0, "triangles": len(mended.triangles)})


def _backs_of_solids(item: EditContext) -> Edit:
    """Closed bodies drawn from both sides: two surfaces in one place, with no inside between them."""
    mended, figures = drop_backs_of_solids(item.mesh)
    if not figures["back_faces"]:
        return Edit(item.mesh)
    crowded = [int((edges_of(m.triangles).uses > 2).sum()) for m in (item.mesh, mended)]
    return Edit(
        mended,
        {"back_faces": figures["back_faces"], "non_manifold_edges": crowded[0]},
        {"back_faces": 0, "non_manifold_edges": crowded[1]},
    )


def _winding(items: Sequence[EditContext]) -> list[Edit]:
    """Solids wound inside out or inconsistently, and open sheets whose back is visible from outside.

    Reported from 0.2 % of the faces on. For sheets `largest_inner_side_share` is the evidence, of the least sure one:
    of what is seen of it from all around, the share of the side taken for its inside (`geom.repair.sheet_orientation`).
    """
    solids = [orient(item.mesh, _backed_elsewhere(item)) for item in items]
    points, triangles, owner = merge_surfaces([mesh for mesh, _ in solids])
    turned = sheet_flips(points, triangles, owner)
    edits: list[Edit] = []
    for item, (mesh, figures) in zip(items, solids, strict=True):
        in_mesh = turned.flips[owner == item.index]
        inner = [t.inner_share for t in turned.sheets if owner[t.faces[0]] == item.index]
        flipped = int(figures["flipped_faces"]) + int(in_mesh.sum())
        mended = flip_faces(mesh, in_mesh)
        if flipped < FLIPPED_SHARE * len(item.mesh.triangles) or flipped == 0:
            edits.append(Edit(mended))
            continue
        evidence = {"turned_sheets": len(inner), "largest_inner_side_share": max(inner)} if inner else {}
        edits.append(Edit(mended, {"misoriented_faces": flipped, **evidence}, {"misoriented_faces": 0, **evidence}))
    return edits


def _normals(item: EditContext) -> Edit:
    """Corner normals that look into a solid. Reported from 0.2 % of the faces on."""
    mesh = item.mesh
    if mesh.normals is None:
        return Edit(mesh)
    away = (normal_cosines(mesh.points, mesh.triangles, mesh.normals) < INWARD_COSINE).all(axis=1)
    if not away.any():
        return Edit(mesh)
    parts = components_of(mesh.points, mesh.triangles)
    away &= parts.solid[parts.label]
    turned = int(away.sum())
    if turned < FLIPPED_SHARE * len(mesh.triangles) or turned == 0:
        return Edit(mesh)
    return Edit(turn_normals(mesh, away), {"inward_normals": turned}, {"inward_normals": 0})


def _fins(item: EditContext) -> Edit:
    """Small sheets hanging on an otherwise closed solid. One triangle is a stray; a larger sheet may be meant."""
    mended, figures = drop_fins(item.mesh)
    if not figures["fin_faces"]:
        return Edit(item.mesh)
    crowded = [int((edges_of(m.triangles).uses > 2).sum()) for m in (item.mesh, mended)]
    return Edit(
        mended,
        {"fin_faces": figures["fin_faces"], "non_manifold_edges": crowded[0]},
        {"fin_faces": 0, "non_manifold_edges": crowded[1]},
        _loss(item.mesh, fin_faces(item.mesh.points, item.mesh.triangles), mended),
    )


def _loss(mesh: Mesh, gone: BoolArray, left: Mesh) -> ShapeUncertainty:
    """How far removed sheets of more than one triangle and 1 % of the area reached out of what is left."""
    removed = mesh.triangles[gone]
    parts = components_of(mesh.points, removed)
    meant = (parts.faces > 1) & (parts.area > MEANT_AREA_SHARE * triangle_areas(mesh.points[mesh.triangles]).sum())
    corners = mesh.points[removed[meant[parts.label]]]
    far = one_sided_hausdorff(corners, left.points, left.triangles, EDIT_TOLERANCE_SHARE * diagonal(mesh.points))
    return ShapeUncertainty(far.attained, far.at)


def _touching_edges(item: EditContext) -> Edit:
    """Solids that touch along single edges; every wedge then gets its own points."""
    split, figures = split_touching_edges(item.mesh)
    if not figures["split_edges"]:
        return Edit(item.mesh)
    crowded = [int((edges_of(m.triangles).uses > 2).sum()) for m in (item.mesh, split)]
    return Edit(split, {"touching_edges": crowded[0]}, {"touching_edges": crowded[1]})


def _t_junctions(item: EditContext) -> Edit:
    """Cracks beside points that lie on the side of a face. Nothing moves; the faces there are split."""
    stitched, figures = stitch_t_junctions(item.mesh)
    if not figures["t_junctions"]:
        return Edit(item.mesh)
    boundary = [int((edges_of(m.triangles).uses == 1).sum()) for m in (item.mesh, stitched)]
    return Edit(
        stitched,
        {"t_junctions": figures["t_junctions"], "boundary_edges": boundary[0]},
        {"t_junctions": 0, "boundary_edges": boundary[1]},
    )


def _bow_ties(item: EditContext) -> Edit:
    """Solids that touch in a point alone; every fan then gets its own point."""
    touching = touching_points(item.mesh.points, item.mesh.triangles)
    if touching.size == 0:
        return Edit(item.mesh)
    split, _ = split_bow_ties(item.mesh, touching)
    return Edit(weld(split), {"non_manifold_vertices": len(touching)}, {"non_manifold_vertices": 0})


def _debris(items: Sequence[EditContext]) -> list[Edit]:
    """Tiny pieces that float, over all meshes: what floats beside one mesh may sit on another. No mesh is emptied."""
    points, triangles, owner = merge_surfaces([item.mesh for item in items])
    gone = loose_debris(*weld_points(points, triangles))
    edits = []
    for index, item in enumerate(items):
        in_mesh = gone[owner == index]
        if not in_mesh.any() or in_mesh.all():
            edits.append(Edit(item.mesh))
            continue
        parts = components_of(item.mesh.points, item.mesh.triangles[in_mesh])
        before = {
            "fragments": parts.count,
            "fragment_area_m2": float(parts.area.sum()),
            "largest_fragment_m": float(parts.extent.max()),
        }
        edits.append(Edit(keep_faces(item.mesh, ~in_mesh), before, dict.fromkeys(before, 0), NO_UNCERTAINTY))
    return edits


def _open_faces(mesh: Mesh) -> int:
    """Faces that belong to components with an edge of an odd number of faces."""
    proper = mesh.triangles[~repeats_point(mesh.triangles)]
    parts = components_of(mesh.points, proper)
    return int(parts.faces[~parts.closed].sum())


def _backed_elsewhere(item: EditContext) -> BoolArray | None:
    """(m,) True for faces that another mesh shows from behind; None when there is no other mesh.

    Such a mesh is the inside of a double-sided drawing, not an inverted solid.
    """
    if len(item.meshes) == 1 or not outward_flips(item.mesh.points, item.mesh.triangles).any():
        return None
    points, triangles, owner = merge_surfaces(item.meshes)
    return has_reverse(weld_points(points, triangles)[1])[owner == item.index]


class EditStep(NamedTuple):
    """One kind of edit over all meshes: name of the repair, code of the finding, its headline, and the edit."""

    name: str
    code: str
    headline: str
    edit: Callable[[Sequence[EditContext]], list[Edit]]


def _each(edit: Callable[[EditContext], Edit]) -> Callable[[Sequence[EditContext]], list[Edit]]:
    return lambda items: [edit(item) for item in items]


# The order matters: a shell's copies are also duplicate faces, surplus faces and fins hide that a shell is closed (and
# what lies in it a cavity), holes need winding.
EDITS: tuple[EditStep, ...] = (
    EditStep(
        "duplicate_shell",
        "asset/duplicate-shell",
        "copies of a closed surface were removed",
        _each(_duplicate_shells),
    ),
    EditStep(
        "degenerate_faces",
        "asset/degenerate-faces",
        "faces without area or present twice were removed",
        _each(_surplus_faces),
    ),
    EditStep(
        "duplicate_shell",
        "asset/duplicate-shell",
        "closed surfaces drawn from both sides were reduced to their outside",
        _each(_backs_of_solids),
    ),
    EditStep(
        "fragment_removal", "asset/loose-fragments", "tiny pieces that float beside the object were removed", _debris
    ),
    EditStep(
        "non_manifold_edge", "asset/non-manifold-edge", "surplus faces on a solid's edges were removed", _each(_fins)
    ),
    EditStep("flip_winding", "asset/inverted-winding", "faces wound the wrong way were turned", _winding),
    EditStep("bad_normals", "asset/bad-normals", "normals that look into a solid were turned", _each(_normals)),
    EditStep(
        "non_manifold_edge",
        "asset/non-manifold-edge",
        "edges along which solids touch were split",
        _each(_touching_edges),
    ),
    EditStep(
        "non_manifold_vertex",
        "asset/non-manifold-vertex",
        "points where solids touch were split",
        _each(_bow_ties),
    ),
    EditStep("crack_stitch", "asset/small-holes", "cracks beside T-junctions were closed", _each(_t_junctions)),
    EditStep("hole_fill", "asset/small-holes", "holes in a nearly closed surface were filled", _each(fill_holes)),
)
