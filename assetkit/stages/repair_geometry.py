"""Observe meshes, mend true defects by bounded edits, observe again; part of stage 2, canonicalize."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from assetkit.stages.geometry_edits import EDITS, Counts, Item
from assetkit.stages.geometry_judgements import judge
from geom.mesh_edit import merge_surfaces
from geom.topology import observe
from geom.weld import weld
from schemas.asset import Topology
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import Mesh
from schemas.outcome import Repair


@dataclass(frozen=True)
class RepairResult:
    """Meshes after the edits, what was observed per mesh and on all (`merged`) before, and on all after."""

    meshes: tuple[Mesh, ...]
    observed: tuple[Topology, ...]
    reobserved: Topology
    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]


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
        edits = [edit(Item(source, i, current)) for i, source in enumerate(meshes)]
        current = [e.mesh for e in edits]
        if reported := [i for i, e in enumerate(edits) if e.before is not None]:
            before = _summed(edits[i].before or {} for i in reported)
            after = _summed(edits[i].after for i in reported)
            repairs.append(_repair(name, code, before, after))
            where = Location(mesh=meshes[reported[0]].name if len(reported) == 1 else None)
            notes.append(_note(code, headline, where, before, after))
    for found in judge(current, any(r.name == "degenerate_faces" for r in repairs)):
        repairs.append(_repair(found.name, found.code, found.before, found.after))
        notes.append(_note(found.code, found.headline, Location(), found.before, found.after))
    return RepairResult(tuple(current), (*observed, merged), _observe_all(current), tuple(notes), tuple(repairs))


def _observe_all(meshes: Sequence[Mesh]) -> Topology:
    points, triangles, _ = merge_surfaces(meshes)
    return observe(points, triangles, "merged")


def _summed(counts: Iterable[Counts]) -> Counts:
    total: Counts = {}
    for each in counts:
        total = {key: total.get(key, 0) + value for key, value in each.items()}
    return total


def _repair(name: str, code: str, before: Counts, after: Counts) -> Repair:
    return Repair(name=name, code=code, stage="canonicalize", before={**before}, after={**after})


def _note(code: str, headline: str, where: Location, before: Counts, after: Counts) -> Diagnostic:
    key = next(iter(before))
    return finding(code, headline, where=where, value=before[key], bound=after[key], unit=key.replace("_", " "))
