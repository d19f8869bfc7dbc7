"""Repairs true defects of meshes by bounded edits; observes topology before and after, and reports each repair."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from assetkit.geometry.distortion import Distortion, crossing_distortion, distortion
from assetkit.geometry.edit import Counts, EditContext
from assetkit.geometry.edits import EDITS
from assetkit.geometry.physical_defects import find_physical_defects
from geom.mesh.edit import merge_surfaces
from geom.mesh.topology import observe
from geom.mesh.weld import weld
from geom.repair.shape_change import ShapeChange, shape_change
from geom.solid.closed_bodies import Bodies, sort_bodies
from geom.solid.self_intersections import Resolver, SelfIntersection, resolve_bodies
from schemas.asset import Topology
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import Mesh
from schemas.outcome import Repair


@dataclass(frozen=True)
class RepairResult:
    """Meshes after the edits, what was observed per mesh and on all (`merged`) before, and on all after.

    `distortions` holds for each reported edit its change of the shape, `change` that of all edits together, also of
    those too slight to be reported. `bodies` are what the mended meshes hold, those that passed through themselves
    resolved except the `unresolved`.
    """

    meshes: tuple[Mesh, ...]
    observed: tuple[Topology, ...]
    reobserved: Topology
    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]
    distortions: tuple[Distortion, ...]
    change: ShapeChange
    bodies: Bodies
    unresolved: tuple[SelfIntersection, ...]


def repair_geometry(meshes: Sequence[Mesh], resolver: Resolver | None = None) -> RepairResult:
    """Welded meshes with their true defects mended, one Repair and one diagnostic per kind of defect found.

    As many meshes come back as went in, in the same order. Points must be finite; at least one face must have area.
    Bodies that pass through themselves are sought when there is a `resolver` for them.
    """
    observed = [observe(m.points, m.triangles, m.name) for m in meshes]
    merged = observe_all(meshes)
    welded = current = [weld(m) for m in meshes]
    repairs: list[Repair] = []
    notes: list[Diagnostic] = []
    distortions: list[Distortion] = []
    for name, code, headline, edit in EDITS:
        before, edits = current, edit([EditContext(source, i, current) for i, source in enumerate(meshes)])
        current = [e.mesh for e in edits]
        if reported := [i for i, e in enumerate(edits) if e.before is not None]:
            change = distortion(name, before, current, edits)
            was = {**_summed(edits[i].before or {} for i in reported), **change.figures()[0]}
            now = {**_summed(edits[i].after for i in reported), **change.figures()[1]}
            distortions.append(change)
            repairs.append(_repair(name, code, was, now))
            where = Location(mesh=meshes[reported[0]].name if len(reported) == 1 else None)
            notes.append(_note(code, headline, where, was, now))
    bodies, crossings = sort_bodies(current), ()
    if resolver is not None:
        bodies, crossings = resolve_bodies(bodies, resolver)
    for defect in find_physical_defects(current, bodies, crossings, any(r.name == "degenerate_faces" for r in repairs)):
        was, now = defect.before, defect.after
        if defect.code == "asset/self-intersection":
            change = crossing_distortion(crossings, current)
            was, now = {**was, **change.figures()[0]}, {**now, **change.figures()[1]}
            distortions.append(change)
        repairs.append(_repair(defect.name, defect.code, was, now))
        notes.append(_note(defect.code, defect.headline, Location(), was, now))
    left = observe_all(current)
    return RepairResult(
        tuple(current),
        (*observed, merged),
        left,
        (*notes, *_non_manifold_findings(left)),
        tuple(repairs),
        tuple(distortions),
        shape_change(merge_surfaces(welded)[:2], merge_surfaces(current)[:2]),
        bodies,
        tuple(c for c in crossings if c.resolved is None),
    )


def _non_manifold_findings(left: Topology) -> tuple[Diagnostic, ...]:
    """The finding on remaining edges with more than two faces: most are parts that meet by design; all are reported."""
    count = left.non_manifold_edges
    if not count:
        return ()
    headline = f"{count} edges of the released surface have more than two faces: parts that meet, or faces drawn twice"
    return (finding("asset/non-manifold-left", headline, value=count, bound=0, unit="edges"),)


def observe_all(meshes: Sequence[Mesh]) -> Topology:
    """What is observed on all meshes taken together (`merged`)."""
    points, triangles, _ = merge_surfaces(meshes)
    return observe(points, triangles, "merged")


def _summed(counts: Iterable[Counts]) -> Counts:
    """Figures added up; of the `largest` of something the largest."""
    total: dict[str, float] = {}
    for each in counts:
        for key, value in each.items():
            known = total.get(key, 0)
            total[key] = max(known, value) if key.startswith("largest") else known + value
    return total


def _repair(name: str, code: str, before: Counts, after: Counts) -> Repair:
    return Repair(name=name, code=code, stage="canonicalize", before={**before}, after={**after})


def _note(code: str, headline: str, where: Location, before: Counts, after: Counts) -> Diagnostic:
    key = next(iter(before))
    return finding(code, headline, where=where, value=before[key], bound=after[key], unit=key.replace("_", " "))
