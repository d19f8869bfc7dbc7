"""Entry of the decomposition cell: `python -m assetkit.colliders.coacd_worker IN.npz OUT.npz CPU_SECONDS`.

CoACD aborts, hangs and grows on some inputs, and its OpenMP runtime clashes with others; nothing but this process loads
it. IN holds `points` (n, 3), `triangles` (m, 3), `method` and the settings of
`assetkit.colliders.decompose.DecompositionSettings`; OUT holds
the corners of all hulls in `points` (k, 3) and the number of corners of each in `counts` (h,).
"""

from __future__ import annotations

import resource
import sys
from typing import Any

import numpy as np


def main(source: str, target: str, cpu_seconds: int) -> None:
    """Read, decompose, write; the system ends the process (SIGXCPU) when it has used `cpu_seconds`."""
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds + 1))
    with np.load(source) as job:
        settings = {key: job[key] for key in job.files}
    hulls = _coacd(settings) if str(settings["method"]) == "coacd" else _vhacd(settings)
    np.savez(target, points=np.concatenate([*hulls, np.empty((0, 3))]), counts=np.array([len(h) for h in hulls]))


def _coacd(job: dict[str, Any]) -> list[np.ndarray]:
    import coacd

    coacd.set_log_level("error")
    parts = coacd.run_coacd(
        coacd.Mesh(job["points"], job["triangles"]),
        threshold=float(job["threshold"]),
        max_convex_hull=-1,  # its own joining crashes on some meshes (issues 63 and 71) and closes openings
        preprocess_mode="off",
        resolution=int(job["resolution"]),
        mcts_nodes=int(job["search_nodes"]),
        mcts_iterations=int(job["search_iterations"]),
        mcts_max_depth=int(job["search_depth"]),
        seed=int(job["seed"]),
    )
    return [np.asarray(points, dtype=np.float64) for points, _ in parts]


def _vhacd(job: dict[str, Any]) -> list[np.ndarray]:
    import vhacdx

    parts = vhacdx.compute_vhacd(
        np.asarray(job["points"], dtype=np.float64),
        # The binding takes faces as one flat run with the corner count in front of each.
        np.insert(np.asarray(job["triangles"], dtype=np.uint32), 0, 3, axis=1).reshape(-1),
        maxConvexHulls=int(job["max_hulls"]),
        resolution=int(job["voxels"]),
        maxNumVerticesPerCH=64,
        asyncACD=False,  # one thread, so that the limit on processor time means the same everywhere
    )
    return [np.asarray(points, dtype=np.float64) for points, _ in parts]


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
