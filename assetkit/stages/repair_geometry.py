"""Observe meshes, mend true defects by bounded edits, observe again; part of stage 2, canonicalize.

Artists' habits are not defects: open parts, parts that touch or interpenetrate, cards, back faces, seams, collapsed
quads, a few slivers. An edit is reported only where something was wrong: see each edit below.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
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
from geom.repair_winding import orient
from geom.solid_bodies import Surface, closed_parts, signed_volume, sort_bodies, tidy, unite
from geom.surface_distance import closest_on_surface, triangle_areas
from geom.topology import observe, repeats_point
from geom.weld import weld, weld_points
from schemas.asset import Topology
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import FloatArray, Mesh
from schemas.outcome import Repair

Counts = Mapping[str, float]

# Fewer surplus faces than this share are what exporters leave behind, unless removing them closes a solid.
SURPLUS_SHARE = 5e-3
# Zero-area faces alone do no harm to a surface; above this share the export went wrong.
DEGENERATE_SHARE = 0.05
FLIPPED_SHARE = 2e-3
# A loop this thin (area over squared perimeter; a circle has 0.08) is a T-junction, not a hole.
CRACK_THINNESS = 2e-3
# An eye in its socket, a dial in its housing: gap between the rim and the other part, over the hole's mean radius.
FITTED_GAP = 0.1
# Naive over united volume.
OVERLAP_BOUND = 1.02
# The asset is an open shell when containers carry this share of its area.
SHELL_SHARE = 0.98
# Edges with an odd number of faces, three or more, that are left after the edits; as a share of all edges.
DIRTY_SHARE = 5e-3


@dataclass(frozen=True)
class RepairResult:
    """Meshes after the edits, what was observed per mesh and on all (`merged`) before, and on all after."""

    meshes: tuple[Mesh, ...]
    observed: tuple[Topology, ...]
    reobserved: Topology
    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]


@dataclass(frozen=True)
class _Item:
    """One mesh on its way through the edits; `surroundings` is the surface of the other meshes."""

    source: Mesh
    mesh: Mesh
    back: FloatArray  # (m,) faces of `mesh` whose reverse is somewhere in the asset
    surroundings: Surface


@dataclass(frozen=True)
class _Edit:
    """An edited mesh; `before` and `after` are None when nothing was wrong enough to be reported."""

    mesh: Mesh
    before: Counts | None = None
    after: Counts = field(default_factory=dict[str, float])


def repair_geometry(meshes: Sequence[Mesh]) -> RepairResult:
    """Welded meshes with their true defects mended, one Repair and one diagnostic per kind of defect found.

    As many meshes come back as went in, in the same order. Points must be finite; at least one face must have area.
    """
    observed = [observe(m.points, m.triangles, m.name) for m in meshes]
    merged = _observe_all(meshes)
    current = [weld(m) for m in meshes]
    repairs: list[Repair] = []
    notes: list[Diagnostic] = []
    for name, code, headline, edit in EDITS:
        edits = [edit(item) for item in _items(meshes, current)]
        current = [e.mesh for e in edits]
        if reported := [i for i, e in enumerate(edits) if e.before is not None]:
            before = _summed(edits[i].before or {} for i in reported)
            after = _summed(edits[i].after for i in reported)
            repairs.append(Repair(name=name, code=code, stage="canonicalize", before=dict(before), after=dict(after)))
            where = Location(mesh=meshes[reported[0]].name if len(reported) == 1 else None)
            notes.append(_note(code, headline, where, before, after))
    for name, code, headline, before, after in _judgements(current):
        repairs.append(Repair(name=name, code=code, stage="canonicalize", before=dict(before), after=dict(after)))
        notes.append(_note(code, headline, Location(), before, after))
    return RepairResult(tuple(current), (*observed, merged), _observe_all(current), tuple(notes), tuple(repairs))


def _surplus_faces(item: _Item) -> _Edit:
    """Degenerate and duplicate faces. Reported when their removal closes a solid or they are many."""
    mended, figures = drop_surplus_faces(item.mesh)
    if len(mended.triangles) == 0:
        return _Edit(item.mesh)
    degenerate, duplicate = int(figures["degenerate_faces"]), int(figures["duplicate_faces"])
    faces = len(item.mesh.triangles)
    wrong = (duplicate > 0 and _open_faces(mended) < _open_faces(item.mesh)) or (
        duplicate >= SURPLUS_SHARE * faces or true_degenerates(item.source) >= DEGENERATE_SHARE * faces
    )
    if degenerate + duplicate == 0 or not wrong:
        return _Edit(mended)
    return _Edit(
        mended,
        {"triangles": faces, "degenerate_faces": degenerate, "duplicate_faces": duplicate},
        {"triangles": len(mended.triangles), "degenerate_faces": 0, "duplicate_faces": 0},
    )


def _duplicate_shells(item: _Item) -> _Edit:
    """Copies of closed shells, always reported: volume and mass would count them."""
    mended, figures = drop_duplicate_shells(item.mesh)
    if not figures["shells"]:
        return _Edit(item.mesh)
    before = {"duplicate_shells": figures["shells"], "triangles": len(item.mesh.triangles)}
    return _Edit(mended, before, {"duplicate_shells": 0, "triangles": len(mended.triangles)})


def _winding(item: _Item) -> _Edit:
    """Solids wound inside out or inconsistently. Reported from 0.2 % of the faces on."""
    mended, figures = orient(item.mesh, item.back)
    flipped = int(figures["flipped_faces"])
    if flipped < FLIPPED_SHARE * len(item.mesh.triangles) or flipped == 0:
        return _Edit(mended)
    return _Edit(mended, {"misoriented_faces": flipped}, {"misoriented_faces": 0})


def _fins(item: _Item) -> _Edit:
    """Small sheets hanging on an otherwise closed solid."""
    mended, figures = drop_fins(item.mesh)
    if not figures["fin_faces"]:
        return _Edit(item.mesh)
    crowded = [int((edges_of(m.triangles).uses > 2).sum()) for m in (item.mesh, mended)]
    return _Edit(
        mended,
        {"fin_faces": figures["fin_faces"], "non_manifold_edges": crowded[0]},
        {"fin_faces": 0, "non_manifold_edges": crowded[1]},
    )


def _bow_ties(item: _Item) -> _Edit:
    """Solids that touch in a point alone; every fan then gets its own point."""
    touching = len(touching_points(item.mesh.points, item.mesh.triangles))
    if touching == 0:
        return _Edit(item.mesh)
    split, _ = split_bow_ties(item.mesh)
    return _Edit(split, {"non_manifold_vertices": touching}, {"non_manifold_vertices": 0})


def _holes(item: _Item) -> _Edit:
    """Holes in nearly closed surfaces, except T-junction cracks and holes that another part is fitted into."""
    mesh = item.mesh
    edges = edges_of(mesh.triangles)
    parts = components_of(mesh.points, mesh.triangles, edges)
    bodies = judge_open_bodies(mesh.points, mesh.triangles, edges, parts)
    holes = [o for b in bodies if b.kind == "holes" for o in _true_holes(b, item)]
    if not holes:
        return _Edit(mesh)
    filled, figures = fill_openings(mesh, holes)
    looped = sum(len(o.points) for o in holes)
    boundary = int((edges.uses == 1).sum())
    return _Edit(
        weld(filled),
        {"holes": len(holes), "boundary_edges": boundary, "filled_area_m2": 0.0},
        {"holes": 0, "boundary_edges": boundary - looped, "filled_area_m2": figures["filled_area"]},
    )


# The order matters: a shell's copies are also duplicate faces, surplus faces hide edges, holes need winding.
EDITS: tuple[tuple[str, str, str, Callable[[_Item], _Edit]], ...] = (
    ("duplicate_shell", "asset/duplicate-shell", "copies of a closed surface were removed", _duplicate_shells),
    ("degenerate_faces", "asset/degenerate-faces", "faces without area or present twice were removed", _surplus_faces),
    ("flip_winding", "asset/inverted-winding", "faces wound the wrong way were turned", _winding),
    ("non_manifold_edge", "asset/non-manifold-edge", "surplus faces on a solid's edges were removed", _fins),
    ("non_manifold_vertex", "asset/non-manifold-vertex", "points where solids touch were split", _bow_ties),
    ("hole_fill", "asset/small-holes", "holes in a nearly closed surface were filled", _holes),
)


def _judgements(meshes: Sequence[Mesh]) -> list[tuple[str, str, str, Counts, Counts]]:
    """Findings that leave the visible surface alone and only steer the physical one."""
    found: list[tuple[str, str, str, Counts, Counts]] = []
    naive, united = _overlap(meshes)
    if naive > OVERLAP_BOUND * united > 0.0:
        before, after = {"volume_m3": naive}, {"volume_m3": united}
        found.append(
            ("self_intersection", "asset/overlapping-bodies", "closed parts of one mesh overlap", before, after)
        )
    bodies = sort_bodies(meshes)
    mouths = sum(len(v.openings) for v in bodies.verdicts if v.kind == "container")
    shell_area = sum(v.area for v in bodies.verdicts if v.kind == "container")
    if mouths and shell_area >= SHELL_SHARE * (bodies.closed_area + bodies.open_area):
        counts: Counts = {"openings": mouths}
        headline = "an open container without wall thickness is kept open"
        found.append(("open_shell_keep_cavity", "asset/open-shell", headline, counts, counts))
    dirty = sum(_odd_edges(m) for m in meshes)
    if dirty > DIRTY_SHARE * 1.5 * sum(len(m.triangles) for m in meshes):  # A closed mesh has 1.5 edges per face.
        headline = "the surface is too damaged for single edits; the physical surface was rebuilt"
        found.append(("mesh_repair", "asset/dirty-mesh", headline, {"odd_edges": dirty}, {"odd_edges": 0}))
    return found


def _overlap(meshes: Sequence[Mesh]) -> tuple[float, float]:
    """Added and united volume of the bodies of those meshes that consist of several closed bodies and nothing open.

    Overlap between meshes is how artists assemble; overlap inside one mesh counts the shared volume twice.
    """
    naive = united = 0.0
    for mesh in meshes:
        bodies, rest, _, _ = closed_parts(tidy(mesh))
        if len(rest.triangles) or len(bodies) < 2 or not _boxes_overlap(bodies):
            continue
        union = unite(bodies)
        if union is not None:
            naive += sum(signed_volume(*body) for body in bodies)
            united += signed_volume(*union)
    return naive, united


def _boxes_overlap(bodies: Sequence[Surface]) -> bool:
    low = np.array([points.min(axis=0) for points, _ in bodies])
    high = np.array([points.max(axis=0) for points, _ in bodies])
    return any(
        bool(((low[i + 1 :] < high[i]) & (high[i + 1 :] > low[i])).all(axis=1).any()) for i in range(len(bodies) - 1)
    )


def _odd_edges(mesh: Mesh) -> int:
    uses = edges_of(mesh.triangles[~repeats_point(mesh.triangles)]).uses
    return int(((uses > 2) & (uses % 2 == 1)).sum())


def _open_faces(mesh: Mesh) -> int:
    """Faces that belong to components with an edge of an odd number of faces."""
    proper = mesh.triangles[~repeats_point(mesh.triangles)]
    parts = components_of(mesh.points, proper)
    return int(parts.faces[~parts.closed].sum())


def _true_holes(body: OpenBody, item: _Item) -> list[Opening]:
    others = np.ones(len(item.mesh.triangles), dtype=bool)
    others[body.faces] = False
    rest = keep_faces(item.mesh, others)
    surfaces = [(rest.points, rest.triangles), item.surroundings]
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


def _items(sources: Sequence[Mesh], current: Sequence[Mesh]) -> list[_Item]:
    points, triangles, owner = merge_surfaces(current)
    _, welded = weld_points(points, triangles)
    back = has_reverse(welded)
    return [
        _Item(source, mesh, back[owner == i], (points, triangles[owner != i]))
        for i, (source, mesh) in enumerate(zip(sources, current, strict=True))
    ]


def _observe_all(meshes: Sequence[Mesh]) -> Topology:
    points, triangles, _ = merge_surfaces(meshes)
    return observe(points, triangles, "merged")


def _summed(counts: Iterable[Counts]) -> Counts:
    total: Counts = {}
    for each in counts:
        total = {key: total.get(key, 0) + value for key, value in each.items()}
    return total


def _note(code: str, headline: str, where: Location, before: Counts, after: Counts) -> Diagnostic:
    key = next(iter(before))
    return finding(code, headline, where=where, value=before[key], bound=after[key], unit=key)
