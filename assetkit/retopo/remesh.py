"""Light meshes of one object with texture coordinates in one common atlas, made in a cell by MeshLab and xatlas.

Two simplifiers in a row: fast-simplification, with few collapses at a time, down to four times the wanted faces, and
MeshLab the rest. The first alone stops early on objects of many shells or tears them; the second alone leaves more
distance on most (figures: docs/benchmarks-appearance.md), and is taken where the first step loses a part.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from assetkit.storage import require_storage
from geom.mesh.corner_normals import corner_normals
from geom.mesh.edit import only_used_points
from geom.mesh.topology import degenerate_faces
from geom.mesh.weld import weld_points
from jobs.cell import Limits, run_cell
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh

LEAST_FACES = 64  # of one mesh: fewer make no body of most shapes
PICTURE_PER_PADDING = 256  # 8 texels between charts of 2048: three halvings of the picture leave one between two
LEAST_PADDING_PX = 2
# Bounded in processor time, so that a busy machine gives the same answer as an idle one. 250,000 faces take 6 s.
REMESH_CPU_S = 120
CELL = Limits(seconds=10.0 * REMESH_CPU_S, memory_mb=8192)


def remeshed(meshes: Sequence[Mesh], faces: int, size_px: int) -> tuple[Mesh, ...] | str:
    """The meshes with about `faces` triangles together, or why there are none.

    Each keeps its name, id, link and material, has smooth normals up to a crease, and one set of texture coordinates
    in an atlas of `size_px` that all of them share, without overlap. Deterministic. Raises OSError when files on the
    way could not be written or read.
    """
    low = np.min([mesh.points.min(axis=0) for mesh in meshes], axis=0)
    high = np.max([mesh.points.max(axis=0) for mesh in meshes], axis=0)
    centre, scale = 0.5 * (low + high), float((high - low).max()) or 1.0
    total = sum(len(mesh.triangles) for mesh in meshes)
    padding_px = max(LEAST_PADDING_PX, size_px // PICTURE_PER_PADDING)
    job: dict[str, FloatArray | IntArray] = {"size_px": np.array(size_px), "padding_px": np.array(padding_px)}
    for k, mesh in enumerate(meshes):
        points, triangles = weld_points((mesh.points - centre) / scale, mesh.triangles)
        job[f"points_{k}"] = points
        job[f"triangles_{k}"] = triangles[~degenerate_faces(points, triangles)].astype(np.int32)
        job[f"faces_{k}"] = np.array(max(LEAST_FACES, len(mesh.triangles) * faces // total))
    surfaces = _in_cell(job, len(meshes))
    if isinstance(surfaces, str):
        return surfaces
    pairs = zip(meshes, surfaces, strict=True)
    return tuple(_light(mesh, points * scale + centre, triangles, uvs) for mesh, (points, triangles, uvs) in pairs)


def _light(mesh: Mesh, points: FloatArray, triangles: IntArray, uvs: FloatArray) -> Mesh:
    normals = corner_normals(points, triangles)
    coordinates = uvs.astype(np.float32)
    return only_used_points(
        replace(mesh, points=points, triangles=triangles, normals=normals, uvs=(coordinates,), colors=None)
    )


def _in_cell(job: dict[str, FloatArray | IntArray], count: int) -> list[tuple[FloatArray, IntArray, FloatArray]] | str:
    """Points, triangles and texture coordinates per mesh as the worker made them, or how it ended."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.npz"), Path(folder, "out.npz")
        np.savez(source, allow_pickle=False, **job)
        module = "assetkit.retopo.remesh_worker"
        argv = [sys.executable, "-P", "-m", module, str(source), str(target), str(REMESH_CPU_S)]
        cell = run_cell(argv, CELL, env={"OMP_NUM_THREADS": "1"})
        require_storage(cell)
        if cell.status != "ok":
            last = (cell.output.strip().splitlines() or ["no output"])[-1][:200]
            return f"remeshing {cell.status.replace('_', ' ')}: {last}"
        with np.load(target) as made:
            surfaces = [(made[f"points_{k}"], made[f"triangles_{k}"], made[f"uvs_{k}"]) for k in range(count)]
    if not all(len(triangles) and np.isfinite(points).all() for points, triangles, _ in surfaces):
        return "remeshing left a mesh without triangles"
    return surfaces
