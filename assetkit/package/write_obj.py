"""Writes a triangle mesh as Wavefront OBJ text whose numbers read back as the same doubles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from schemas.arrays import Float32Array, FloatArray, IntArray


def write_obj(
    path: Path,
    points: FloatArray,
    triangles: IntArray,
    uvs: Float32Array | None = None,
    normals: Float32Array | None = None,
    material: tuple[str, str] | None = None,
) -> None:
    """A Wavefront OBJ whose numbers read back exactly: the shortest decimal that gives the same double.

    `uvs` (m, 3, 2) and `normals` (m, 3, 3) are those of the corners. `material` is a name and the MTL file, beside the
    mesh, that holds it.
    """
    lines = [] if material is None else [f"mtllib {material[1]}", f"usemtl {material[0]}"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, dtype=np.float64).tolist()]
    corners = (np.asarray(triangles, dtype=np.int64) + 1).tolist()
    if uvs is not None:
        lines += [f"vt {u!r} {v!r}" for u, v in uvs.reshape(-1, 2).tolist()]
    if normals is not None:
        lines += [f"vn {x!r} {y!r} {z!r}" for x, y, z in normals.reshape(-1, 3).tolist()]
    for number, triangle in enumerate(corners):
        lines.append("f " + " ".join(_corner(c, 3 * number + k + 1, uvs, normals) for k, c in enumerate(triangle)))
    path.write_text("\n".join(lines) + "\n")


def _corner(point: int, row: int, uvs: Float32Array | None, normals: Float32Array | None) -> str:
    """A corner of a face: the numbers of its point, texture coordinate and normal."""
    if normals is not None:
        return f"{point}/{'' if uvs is None else row}/{row}"
    return str(point) if uvs is None else f"{point}/{row}"
