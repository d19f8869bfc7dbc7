"""`python -m benchmarks.assets.fuzz.one_case FOLDER FILE NOTE`: discover, read and canonicalize one source; for use
in a cell.

Writes a JSON note: codes of the findings, the traceback of any exception, and broken promises about values.
"""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path

import numpy as np

from assetkit.geometry.canonical_model import canonicalize
from assetkit.materials.normalize import normalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stage import Intake
from assetkit.stages.intake import ReadSource
from schemas.diagnostics import Diagnostic, Severity
from schemas.model import Mesh


def examine(folder: Path, file: Path) -> dict[str, object]:
    """What became of `file` below `folder`: `accepted` objects, `codes`, `broken` promises, `trace` of an exception."""
    findings: list[Diagnostic] = []
    broken: list[str] = []
    canonical_count = 0
    try:
        candidates = [c for c in discover([folder]) if c.file.path == file]
        candidates = candidates or (discover([file]) if file.exists() else [])
        if not candidates:
            return {"made": 0, "codes": ["(an empty folder)"], "broken": []}
        taken = ReadSource().run(candidates[0], Options())
        findings += taken.diagnostics
        if not taken.objects and not any(d.severity is Severity.ERROR for d in findings):
            broken.append("nothing came back and nothing was said")
        for item in taken.objects[:2]:
            broken += promises(item)
            outcome = canonicalize(item, file.name, Options())
            findings += outcome.diagnostics
            if outcome.value is not None:
                canonical_count += 1
                broken += [p for m in outcome.value.meshes for p in mesh_promises(m)]
                if not all(0 < e < 1e5 or e == 0 for e in outcome.value.section.extent_m.value):
                    broken.append(f"extent {outcome.value.section.extent_m.value}")
            elif not any(d.severity is Severity.ERROR for d in outcome.diagnostics):
                broken.append("canonicalize gave nothing and said nothing")
            findings += normalize(item.model).diagnostics
    except MemoryError:
        raise
    except Exception:
        return {
            "made": canonical_count,
            "codes": [d.code for d in findings],
            "broken": broken,
            "trace": traceback.format_exc(),
        }
    for diagnostic in findings:
        if str(folder) in diagnostic.model_dump_json():
            broken.append(f"an absolute path in {diagnostic.code}: {diagnostic.headline} {diagnostic.where}")
    codes = {d.code: d.severity.value for d in findings}
    return {
        "made": canonical_count,
        "codes": sorted(codes),
        "errors": [c for c in codes if codes[c] == "error"],
        "broken": broken,
    }


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
        if values is not None and not np.isfinite(values).all():
            broken.append(f"{name} are not finite")
    return broken


if __name__ == "__main__":
    Path(sys.argv[3]).write_text(json.dumps(examine(Path(sys.argv[1]), Path(sys.argv[2]))))
