"""Approximate convex decomposition in a process of its own (CoACD: Wei et al. 2022; V-HACD: Mamou 2016).

CoACD on a raw mesh takes 7 to 90 seconds and aborts or hangs on some. Here it gets what it is good at: a closed
manifold of unit size, simplified to a bounded error, and a shorter search: the same hulls in 1 to 4 seconds.
"""

from __future__ import annotations

import signal
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from manifold3d import Error, Manifold, Mesh64

from geom.cavity import Cavity, keeps_cavity
from geom.hull import hull_shape, thickness, volume
from geom.merge_hulls import merge_hulls
from geom.weld import diagonal
from jobs.cell import CellResult, Limits, run_cell
from schemas.model import FloatArray, IntArray
from schemas.physics import CollisionShape

# Simplification: first and largest error allowed, in units of the half extent, until so few faces remain.
LEAST_ERROR, MOST_ERROR, ERROR_STEP = 0.0025, 0.01, 1.4
TARGET_FACES = 2500
# Hulls below these shares of the diagonal (and of its cube) are slivers: engines reject or mishandle them.
LEAST_THICKNESS, LEAST_VOLUME = 2e-4, 1e-7
# Joining so many pieces takes a second or two; beyond, the mesh is too intricate for this threshold.
MOST_PARTS = 200
# The work is bounded in processor time, so that a busy machine gives the same answer as an idle one.
CPU_SECONDS = 20
CELL = Limits(seconds=10.0 * CPU_SECONDS, memory_mb=4096)


@dataclass(frozen=True)
class Settings:
    """One way to decompose; lengths are shares of half the largest extent.

    threshold          CoACD's concavity at which a piece counts as convex.
    max_hulls          join neighbours beyond this number (V-HACD: stop there).
    resolution         CoACD's samples per concavity measure (default 2000); 500 changes the result little.
    search_*           CoACD's tree search; its defaults 20, 150, 3 give the same hulls in three times the time.
    voxels             V-HACD's voxel budget.
    """

    method: Literal["coacd", "vhacd"] = "coacd"
    threshold: float = 0.05
    max_hulls: int = 32
    resolution: int = 500
    search_nodes: int = 15
    search_iterations: int = 60
    search_depth: int = 2
    voxels: int = 400_000
    seed: int = 0


@dataclass(frozen=True)
class Decomposition:
    """Convex hulls in the frame of the input, or none and the reason; `dropped` counts slivers left out."""

    shapes: tuple[CollisionShape, ...]
    reason: str = ""
    dropped: int = 0


def decompose(
    points: FloatArray,
    triangles: IntArray,
    settings: Settings,
    work_dir: Path,
    cavities: Sequence[Cavity] = (),
    limits: Limits = CELL,
) -> Decomposition:
    """Hulls of at most 64 points each that cover the volume inside a closed surface (metres).

    Where the library finds more than `max_hulls`, neighbours are joined, but never across one of `cavities`. Never
    raises for what the mesh is or the library does: the reason says it. Same input, same hulls.
    """
    if not np.isfinite(points).all():
        return Decomposition((), "a coordinate is not finite")
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    scale = 0.5 * float(np.ptp(points, axis=0).max())
    if not scale > 0.0:
        return Decomposition((), "the surface has no extent")
    body = _manifold((points - centre) / scale, triangles)
    if body is None:
        return Decomposition((), "the surface is not a closed manifold")
    mesh = simplified(body).to_mesh64()
    light, faces = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int32)
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        options = {key: np.array(value) for key, value in asdict(settings).items()}
        np.savez(source, allow_pickle=False, points=light, triangles=faces, **options)
        argv = [sys.executable, "-P", "-m", "assetkit.coacd_worker", str(source), str(target), str(CPU_SECONDS)]
        cell = run_cell(argv, limits, env={"OMP_NUM_THREADS": "1"})
        if cell.status != "ok":
            return Decomposition((), f"{settings.method} {_ending(cell, limits)}")
        with np.load(target) as result:
            parts = np.split(result["points"], np.cumsum(result["counts"])[:-1])
    return _checked([part * scale + centre for part in parts], diagonal(points), settings, cavities)


def _ending(cell: CellResult, limits: Limits) -> str:
    """How a cell ended that gave nothing."""
    if cell.returncode == -signal.SIGXCPU:
        return f"took more than {CPU_SECONDS} s of processor time"
    return f"timeout after {limits.seconds:g} s" if cell.status == "timeout" else cell.status.replace("_", " ")


def simplified(body: Manifold) -> Manifold:
    """`body` (half extent 1) with about `TARGET_FACES` faces, or as few as an error of `MOST_ERROR` allows."""
    error = LEAST_ERROR
    light = body.simplify(error)
    while light.num_tri() > TARGET_FACES and error < MOST_ERROR:
        error = min(error * ERROR_STEP, MOST_ERROR)
        light = body.simplify(error)
    # A wall thinner than the error would vanish.
    return light if light.volume() > 0.9 * body.volume() else body


def _manifold(points: FloatArray, triangles: IntArray) -> Manifold | None:
    body = Manifold(Mesh64(np.ascontiguousarray(points, dtype=np.float64), triangles.astype(np.uint64)))
    return body if body.status() == Error.NoError and body.volume() > 0.0 else None


def _checked(parts: list[FloatArray], size: float, settings: Settings, cavities: Sequence[Cavity]) -> Decomposition:
    """Hulls worth having, or the reason why there are none."""
    if not parts or not all(np.isfinite(part).all() for part in parts):
        return Decomposition((), f"{settings.method} returned no finite hulls")
    if len(parts) > MOST_PARTS:
        return Decomposition((), f"{len(parts)} parts, more than {MOST_PARTS}")
    sound = [part for part in parts if _is_sound(hull_shape(part), size)]
    joined = merge_hulls(sound, settings.max_hulls, lambda corners: _keeps_all(corners, cavities))
    kept = tuple(shape for shape in map(hull_shape, joined) if shape is not None)
    dropped = len(parts) - len(sound)
    if not kept:
        return Decomposition((), "all hulls are slivers", dropped)
    if len(kept) > settings.max_hulls:
        return Decomposition((), f"{len(kept)} hulls, more than {settings.max_hulls}", dropped)
    return Decomposition(kept, "", dropped)


def _keeps_all(corners: FloatArray, cavities: Sequence[Cavity]) -> bool:
    shape = hull_shape(corners)
    return shape is None or all(keeps_cavity([shape], cavity) for cavity in cavities)


def _is_sound(shape: CollisionShape | None, size: float) -> bool:
    if shape is None or shape.points is None or shape.triangles is None:
        return False
    thick = thickness(shape.points, shape.triangles) >= LEAST_THICKNESS * size
    return thick and volume(shape.points, shape.triangles) >= LEAST_VOLUME * size**3
