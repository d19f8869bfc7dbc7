"""Exact self-union of a closed surface that intersects itself: the outward surface, computed in a child process."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from assetkit.storage import require_storage
from geom.mesh.weld import weld_points
from geom.solid.self_intersections import Resolved
from jobs.cell import Limits, run_cell
from schemas.arrays import FloatArray, IntArray

# Bounded in processor time, so that a busy machine gives the same answer as an idle one. 80,000 faces take a second.
UNION_CPU_S = 30
CELL = Limits(seconds=10.0 * UNION_CPU_S, memory_mb=4096)


def self_union(points: FloatArray, triangles: IntArray) -> Resolved | None:
    """The closed outward surface around everything that `points`, `triangles` wind about at least once.

    None when the exact union fails or takes longer than `UNION_CPU_S`. Deterministic.
    Raises OSError when files on the way could not be written or read.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    centre, scale = 0.5 * (low + high), float((high - low).max()) or 1.0
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.npz"), Path(folder, "out.npz")
        np.savez(source, points=(points - centre) / scale, triangles=triangles)
        argv = [
            sys.executable,
            "-P",
            "-m",
            "assetkit.colliders.self_union_worker",
            str(source),
            str(target),
            str(UNION_CPU_S),
        ]
        result = run_cell(argv, CELL, env={"OMP_NUM_THREADS": "1"})
        require_storage(result)
        if result.status != "ok":
            return None
        with np.load(target) as union:
            united = weld_points(union["points"] * scale + centre, union["triangles"], 0.0)
            before, after = (int(n) for n in union["intersecting_faces"])
    return Resolved(united, before, after) if len(united[1]) else None
