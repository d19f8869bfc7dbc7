"""Reads MuJoCo's own mesh files (.msh): counts, then points, normals, texture coordinates and triangles, binary.

mujoco.readthedocs.io/en/stable/XMLreference.html#asset-mesh ("legacy MSH file format").
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from assetkit.sources.source_file import SourceFile
from geom.mesh.finite import require_finite
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.evidence import declared, default
from schemas.model import Mesh, Model, Node
from schemas.outcome import Outcome

_COUNTS_BYTES = 16  # four counts, int32 little-endian


def read_msh(source: SourceFile) -> Outcome[Model]:
    """The one mesh of a file. Normals are left out: the corner order decides. v of the file points down.

    Raises InvalidInput: `asset/truncated` where counts and size disagree, `asset/index-out-of-range`,
    `asset/nonfinite-vertices`, `asset/no-faces`.
    """
    data, where = source.path.read_bytes(), Location(file=source.relative)
    counts = np.frombuffer(data[:_COUNTS_BYTES], dtype="<i4") if len(data) >= _COUNTS_BYTES else np.zeros(4, "<i4")
    points, normals, coordinates, triangles = (int(n) for n in counts)
    expected = _COUNTS_BYTES + 12 * points + 12 * normals + 8 * coordinates + 12 * triangles
    if min(points, normals, coordinates, triangles) < 0 or points == 0 or expected != len(data):
        headline = "the counts of the .msh file do not fit its size"
        raise InvalidInput(
            finding("asset/truncated", headline, where=where, value=len(data), bound=expected, unit="bytes")
        )
    if triangles == 0:
        raise InvalidInput(finding("asset/no-faces", "the .msh file has points and no triangles", where=where))
    floats = np.frombuffer(data, dtype="<f4", count=3 * points + 3 * normals + 2 * coordinates, offset=_COUNTS_BYTES)
    vertices = floats[: 3 * points].reshape(-1, 3).astype(np.float64)
    require_finite(vertices, where)
    faces = np.frombuffer(data, dtype="<i4", count=3 * triangles, offset=expected - 12 * triangles).reshape(-1, 3)
    if faces.min() < 0 or faces.max() >= points:
        headline = "a triangle of the .msh file names a point that is not there"
        value = int(faces.max())
        raise InvalidInput(finding("asset/index-out-of-range", headline, where=where, value=value, bound=points - 1))
    uvs = ()
    if coordinates == points:
        uv = floats[3 * points + 3 * normals :].reshape(-1, 2).copy()
        uv[:, 1] = 1.0 - uv[:, 1]
        uvs = (uv[faces].astype(np.float32),)
    name = Path(source.path).stem
    mesh = Mesh(name, vertices, faces.astype(np.int32), uvs=uvs, source_path=f"/{name}")
    model = Model(
        meshes=(mesh,),
        materials=(),
        textures=(),
        nodes=(Node(f"/{name}", np.eye(4), (0,)),),
        meters_per_unit=declared(1.0, "MJCF: metres"),
        up_axis=default("z", ".msh declares no up axis"),
    )
    return Outcome(model)
