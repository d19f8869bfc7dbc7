"""Removal of surplus faces of a `Mesh`: degenerate and duplicate ones, back faces of solids, folded flaps, fins."""

from __future__ import annotations

import numpy as np

from geom.mesh.components import MIN_COMPACTNESS, components_of
from geom.mesh.duplicate_shells import DOUBLE_SIDED_SHARE, has_reverse, later_copies, oriented_keys, row_numbers
from geom.mesh.edges import Edges, consistent_flips, edges_of, face_components
from geom.mesh.edit import keep_faces
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.topology import degenerate_faces, duplicate_faces, repeats_point
from geom.repair.back_faces import reversed_copies
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.model import Mesh

Figures = dict[str, float]
# Fins larger than this share of their component are parts of the design.
FIN_AREA_SHARE = 0.05
# A single triangle is a stray, not a part: up to this share.
STRAY_TRIANGLE_SHARE = 0.15


def drop_surplus_faces(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded) without degenerate and duplicate faces, except those that hold the surface together.

    A face that repeats a point always goes. A flat one with three points goes only if it lies on an edge that has not
    exactly two faces: otherwise removing it would open a crack (a T-junction closed by a sliver). A copy with the same
    winding goes. A copy with the opposite winding goes only where it makes the number of faces at an edge odd, or where
    without it and its neighbours of that kind every edge there has two faces: the others are back faces drawn for
    double-sided rendering, or two bodies in contact. Of a face and its reverse the side stays that agrees with
    the faces around. A flap (faces and their reverses folded onto each other that hang on a crowded edge, as scanners
    leave them) goes with both sides. Figures: `degenerate_faces` and `duplicate_faces` removed.
    """
    proper = ~repeats_point(mesh.triangles)
    same = np.zeros(len(proper), dtype=bool)
    same[proper] = later_copies(oriented_keys(mesh.triangles[proper]))
    remaining = np.flatnonzero(proper & ~same)
    reverse = _odd_copies(mesh.triangles[remaining])
    remaining, dropped, reversed_count = remaining[~reverse], remaining[reverse], int(reverse.sum())
    flips, _ = consistent_flips(edges_of(mesh.triangles[remaining]))
    remaining = _exchanged(mesh.triangles, remaining, dropped, flips)
    flaps = _folded_flaps(mesh.points, mesh.triangles[remaining])
    remaining, reversed_count = remaining[~flaps], reversed_count + int(flaps.sum())
    hanging = _hanging_slivers(mesh.points, mesh.triangles[remaining])
    remaining, hanging_count = remaining[~hanging], int(hanging.sum())
    figures: Figures = {
        "degenerate_faces": int((~proper).sum()) + hanging_count,
        "duplicate_faces": int(same.sum()) + reversed_count,
    }
    return keep_faces(mesh, remaining), figures


def drop_backs_of_solids(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` (welded, no repeated points) with the outer side only of closed bodies that are drawn from both sides.

    Such a component has most of its faces in both windings (`DOUBLE_SIDED_SHARE`), and one of each pair makes a closed
    surface with two faces at every edge that encloses a volume: its inside is never visible. Of each pair the outward
    face stays, whatever the order in the file. Sheets, which are seen from both sides, and bodies in contact,
    which share single faces, keep theirs. Figures: `back_faces` removed.
    """
    back = reversed_copies(mesh.triangles)
    if not back.any():
        return mesh, {"back_faces": 0}
    _, whole = face_components(edges_of(mesh.triangles))
    share = np.bincount(whole, has_reverse(mesh.triangles)) / np.bincount(whole)
    doubled = (share >= DOUBLE_SIDED_SHARE)[whole]
    front, dropped = np.flatnonzero(doubled & ~back), np.flatnonzero(doubled & back)
    single = mesh.triangles[front]
    edges = edges_of(single)
    flips, _ = consistent_flips(edges)
    agreed = np.where(flips[:, None], single[:, [0, 2, 1]], single)
    parts = components_of(mesh.points, agreed)
    crowded = np.bincount(parts.label, (edges.uses[edges.of_face] != 2).any(axis=1), parts.count) > 0
    compact = np.abs(parts.volume) > MIN_COMPACTNESS * parts.area**1.5
    body = (parts.solid & compact & ~crowded)[parts.label]
    outer = _exchanged(mesh.triangles, front, dropped, flips ^ (parts.volume < 0.0)[parts.label])[body]
    settled = np.isin(whole, whole[front[body]])
    remaining = np.sort(np.concatenate([np.flatnonzero(~settled), outer]))
    return keep_faces(mesh, remaining), {"back_faces": len(mesh.triangles) - len(remaining)}


def true_degenerates(mesh: Mesh) -> int:
    """Faces of `mesh`, as read, that repeat one point with the same texture coordinates.

    Where the coordinates differ the face is the collapsed side of a quad, as at the pole of a sphere: by design.
    """
    count = np.zeros(len(mesh.triangles), dtype=bool)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        same = mesh.triangles[:, a] == mesh.triangles[:, b]
        for uv in mesh.uvs:
            same = same & (uv[:, a] == uv[:, b]).all(axis=1)
        count |= same
    return int(count.sum())


def drop_fins(mesh: Mesh) -> tuple[Mesh, Figures]:
    """`mesh` without the small sheets that hang on a solid's edges, where that leaves the solid closed.

    Sheets are faces connected through edges with exactly two faces. A fin is a sheet with a free edge that also touches
    an edge with three or more faces; all fins of a component together have at most 5 % of its area (15 % when it is one
    triangle), and without them the component is closed. Other non-manifold edges are boards and cards that meet by
    design, and stay.
    Figures: `fin_faces` removed.
    """
    fins = fin_faces(mesh.points, mesh.triangles)
    return keep_faces(mesh, ~fins), {"fin_faces": int(fins.sum())}


def fin_faces(points: FloatArray, triangles: IntArray) -> BoolArray:
    """(m,) True for the faces `drop_fins` removes."""
    none = np.zeros(len(triangles), dtype=bool)
    edges = edges_of(triangles)
    if not ((edges.uses > 2) & (edges.uses % 2 == 1)).any():
        return none
    count, sheet = face_components(edges, edges.uses == 2)
    uses = edges.uses[edges.of_face]
    free = np.bincount(sheet[(uses == 1).any(axis=1)], minlength=count) > 0
    crowded = np.bincount(sheet[(uses > 2).any(axis=1)], minlength=count) > 0
    candidate = (free & crowded)[sheet]
    _, label = face_components(edges)
    areas = triangle_areas(points[triangles])
    share = np.bincount(label, areas * candidate) / np.maximum(np.bincount(label, areas), np.finfo(float).tiny)
    alone = np.bincount(label, candidate) == 1
    candidate &= (share <= np.where(alone, STRAY_TRIANGLE_SHARE, FIN_AREA_SHARE))[label]
    if not candidate.any():
        return none
    rest = np.flatnonzero(~candidate)
    parts = components_of(points, triangles[rest])
    whole = np.ones(label.max() + 1, dtype=bool)
    np.logical_and.at(whole, label[rest], parts.closed[parts.label])
    return candidate & whole[label]


def _odd_copies(triangles: IntArray) -> BoolArray:
    """(m,) True for later copies all of whose edges have an odd number, three or more, of faces."""
    later = duplicate_faces(triangles)
    if not later.any():
        return later
    edges = edges_of(triangles)
    uses = edges.uses[edges.of_face]
    return later & (((uses > 2) & (uses % 2 == 1)).all(axis=1) | _surplus_sheets(later, edges))


def _exchanged(triangles: IntArray, remaining: IntArray, dropped: IntArray, flips: BoolArray) -> IntArray:
    """`remaining` (k,) faces, replaced by their reverses in `dropped` where `flips` (k,) is True."""
    if len(dropped) == 0:
        return remaining
    key = row_numbers(np.sort(triangles[np.concatenate([remaining, dropped])], axis=1))
    of_remaining, of_dropped = key[: len(remaining)], key[len(remaining) :]
    order = np.argsort(of_dropped, kind="stable")
    place = order[np.minimum(np.searchsorted(of_dropped, of_remaining, sorter=order), len(dropped) - 1)]
    return np.where(flips & (of_dropped[place] == of_remaining), dropped[place], remaining)


def _surplus_sheets(later: BoolArray, edges: Edges) -> BoolArray:
    """(m,) True for later copies in sheets without which every edge of theirs has exactly two faces.

    Neighbouring copies share edges with an even number of faces. A body that touches another has its own faces beside
    the copy, a double-sided sheet ends where its copy ends: they keep theirs. Components with most of their faces drawn
    twice are double-sided on purpose.
    """
    copies = np.flatnonzero(later)
    of_copies = edges.of_face[copies]
    copy_uses = np.bincount(of_copies.reshape(-1), minlength=len(edges.uses))
    _, sheet = face_components(edges, copy_uses > 0)
    mends = ((edges.uses - copy_uses)[of_copies] == 2).all(axis=1)
    whole = np.ones(sheet.max() + 1, dtype=bool)
    np.logical_and.at(whole, sheet[copies], mends)
    _, label = face_components(edges)
    double_sided = np.bincount(label, later) >= 0.5 * DOUBLE_SIDED_SHARE * np.bincount(label)
    return later & whole[sheet] & ~double_sided[label]


def _folded_flaps(points: FloatArray, triangles: IntArray) -> BoolArray:
    """(m,) True for sheets made of faces and their reverses only, at crowded edges, with at most 5 % of the area."""
    twin = has_reverse(triangles)
    if not twin.any():
        return twin
    edges = edges_of(triangles)
    count, sheet = face_components(edges, edges.uses == 2)
    crowded = np.bincount(sheet[(edges.uses[edges.of_face] > 2).any(axis=1)], minlength=count) > 0
    folded = crowded & (np.bincount(sheet, minlength=count) > 1) & (np.bincount(sheet[~twin], minlength=count) == 0)
    _, label = face_components(edges)
    areas = triangle_areas(points[triangles])
    share = np.bincount(label, areas * folded[sheet]) / np.maximum(np.bincount(label, areas), np.finfo(float).tiny)
    double_sided = np.bincount(label, twin) >= DOUBLE_SIDED_SHARE * np.bincount(label)
    return folded[sheet] & ((share <= FIN_AREA_SHARE) & ~double_sided)[label]


def _hanging_slivers(points: FloatArray, triangles: IntArray) -> BoolArray:
    """(m,) True for flat faces with three points on an edge that has not exactly two faces."""
    flat = degenerate_faces(points, triangles)
    if not flat.any():
        return flat
    edges = edges_of(triangles)
    return flat & (edges.uses[edges.of_face] % 2 == 1).any(axis=1)
