"""Reads one source asset as the pipeline does: discovery, reader, canonicalization, appearance; checks its promises."""

from __future__ import annotations

import traceback
from pathlib import Path

import numpy as np

from assetkit.geometry.canonical_model import canonicalize
from assetkit.materials.normalize import normalize
from assetkit.options import Options
from assetkit.sources.discover import SourceAsset, discover
from assetkit.stage import Intake
from assetkit.stages.intake import ReadSource
from assetkit.storage import finding_from_exception
from schemas.diagnostics import Diagnostic, Severity
from schemas.model import Mesh
from tests.suites.fuzz.readers.note import Note


def read(folder: Path, file: Path) -> Note:
    """What became of the asset `file` below `folder`."""
    note = Note()
    candidates = [c for c in discover([folder]) if c.file.path == file]
    candidates = candidates or (discover([file]) if file.exists() else [])
    if not candidates:
        note.codes.append("(an empty folder)")
        return note
    findings: list[Diagnostic] = []
    try:
        _read(candidates[0], findings, note)
    except MemoryError:
        raise
    except Exception as error:
        findings.append(finding_from_exception(error, candidates[0].file, ()))
        if findings[-1].code == "asset/internal-error":
            note.trace = traceback.format_exc()
    note.add(findings, folder)
    return note


def _read(candidate: SourceAsset, findings: list[Diagnostic], note: Note) -> None:
    taken = ReadSource().run(candidate, Options())
    findings += taken.diagnostics
    if not taken.objects and not any(d.severity is Severity.ERROR for d in findings):
        note.broken.append("nothing came back and no error was reported")
    for item in taken.objects[:2]:
        note.broken += promises(item)
        outcome = canonicalize(item, candidate.file.path.name, Options())
        findings += outcome.diagnostics
        if outcome.value is not None:
            note.made += 1
            note.broken += [p for m in outcome.value.meshes for p in mesh_promises(m)]
            if not all(0.0 <= e < np.inf for e in outcome.value.section.extent_m.value):
                note.broken.append(f"extent {outcome.value.section.extent_m.value}")
        elif not any(d.severity is Severity.ERROR for d in outcome.diagnostics):
            note.broken.append("canonicalize gave no value and no error")
        findings += normalize(item.model).diagnostics


def promises(item: Intake) -> list[str]:
    """What the rest of the pipeline takes for granted about a model."""
    model = item.model
    broken = [p for m in model.meshes for p in mesh_promises(m)]
    names = [t.name for t in model.textures]
    if len(set(names)) < len(names):
        broken.append("texture names repeat")
    used = {m.material for m in model.meshes if m.material is not None}
    broken += [f"material {i} of {len(model.materials)}" for i in used if not 0 <= i < len(model.materials)]
    if not all(n.X_PN.shape == (4, 4) for n in model.nodes):
        broken.append("a node without a 4x4 pose")
    return broken


def mesh_promises(mesh: Mesh) -> list[str]:
    """The promises of `schemas.model.Mesh`."""
    broken = []
    if not np.isfinite(mesh.points).all():
        broken.append("points are not finite")
    if len(mesh.triangles) and not (mesh.triangles.min() >= 0 and mesh.triangles.max() < len(mesh.points)):
        broken.append("triangles name points that are not there")
    corners = [("normals", mesh.normals, 3), ("colors", mesh.colors, 4), *(("uvs", uv, 2) for uv in mesh.uvs)]
    for name, values, width in corners:
        if values is not None and values.shape != (len(mesh.triangles), 3, width):
            broken.append(f"{name} have the shape {values.shape}")
        if values is not None and name != "uvs" and not np.isfinite(values).all():  # uvs: the stage of appearance
            broken.append(f"{name} are not finite")
    return broken
