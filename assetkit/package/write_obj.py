"""Writes a triangle mesh as Wavefront OBJ text whose numbers read back as the same doubles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from schemas.arrays import Float32Array, FloatArray, IntArray


def write_obj(path: Path, points: FloatArray, triangles: IntArray, uvs: Float32Array | None = None) -> None:
    """A Wavefront OBJ whose numbers read back exactly: the shortest decimal that gives the same double."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, dtype=np.float64).tolist()]
    corners = (np.asarray(triangles, dtype=np.int64) + 1).tolist()
    if uvs is None:
        lines += [f"f {a} {b} {c}" for a, b, c in corners]
    else:
        lines += [f"vt {u!r} {v!r}" for u, v in uvs.reshape(-1, 2).tolist()]
        lines += [f"f {a}/{3 * i + 1} {b}/{3 * i + 2} {c}/{3 * i + 3}" for i, (a, b, c) in enumerate(corners)]
    path.write_text("\n".join(lines) + "\n")
