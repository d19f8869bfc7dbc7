"""Approximate convex decomposition: by plane cuts, by CoACD (Wei et al. 2022) or by V-HACD (Mamou 2016).

CoACD on a raw mesh takes 7 to 90 seconds and aborts or hangs on some. Here it gets what it is good at, a closed
manifold of unit size with few faces, in a process of its own with limits. What either library returns is taken as
advice where to cut: the body inside each of its hulls goes on as a piece, so that every method ends with hulls that
fill the body, of which there are few enough.
"""

from __future__ import annotations

import signal
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Literal

import numpy as np
from manifold3d import Manifold

from assetkit.storage import require_storage
from geom.convex.hull import thickness, volume
from geom.decomposition.decompose import convex_parts
from geom.decomposition.plane_cuts import CRUMB_SHARE, cut_sectors
from geom.decomposition.simplified_body import SimplifiedBody
from geom.features.cavities import Cavity
from geom.features.resting_planes import hull_within, resting_planes
from geom.mesh.manifold_arrays import manifold_arrays
from jobs.cell import CellResult, Limits, run_cell
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

# Hulls below these shares of the diagonal (and of its cube) are slivers: engines reject or mishandle them.
LEAST_THICKNESS, LEAST_VOLUME = 2e-4, 1e-7
# More parts than this are too many for 32 hulls; CoACD does not run on more faces than this.
MOST_SEPARATE_PARTS, MOST_FACES = 200, 6000
# A ring whose section is convex has hulls of sectors that hold this much more at most, which are chords of the hole.
SECTORS_FILL = 1.05
# The work is bounded in processor time, so that a busy machine gives the same answer as an idle one.
DECOMPOSITION_CPU_S = 20  # twice what the dev assets need alone on a machine: a busy one must not change the outcome
CELL = Limits(seconds=10.0 * DECOMPOSITION_CPU_S, memory_mb=4096)


@dataclass(frozen=True)
class DecompositionSettings:
    """Method and parameters of a decomposition; lengths are shares of half the largest extent.

    threshold          CoACD's concavity at which a piece counts as convex.
    max_hulls          join neighbours beyond this number.
    max_pieces         cut no further than into so many before joining.
    sector_planes      first cut by so many planes through the axis of the opening that holds most; all that `sectors`
                       does, about the axis of the widest hole that is open from end to end.
    balance            how much cuts prefer many small excesses to one large (`geom.decomposition.plane_cuts.CutGoal`).
    resolution         CoACD's samples per concavity measure (default 2000); 500 changes the result little.
    search_*           CoACD's tree search; its defaults 20, 150, 3 give the same hulls in three times the time.
    voxels             V-HACD's voxel budget.
    """

    method: Literal["sectors", "cuts", "coacd", "vhacd"] = "coacd"
    threshold: float = 0.05
    max_hulls: int = 32
    max_pieces: int = 80
    sector_planes: int = 0
    balance: float = 1.25
    resolution: int = 500
    search_nodes: int = 15
    search_iterations: int = 60
    search_depth: int = 2
    voxels: int = 400_000
    seed: int = 0

    def __str__(self) -> str:
        """Library, version and the parameters that decide the result, as text for the record."""
        if self.method == "coacd":
            search = f"search {self.search_nodes}/{self.search_iterations}/{self.search_depth}"
            return f"coacd {version('coacd')}, threshold {self.threshold:g}, {search}, seed {self.seed}"
        if self.method == "vhacd":
            return f"vhacdx {version('vhacdx')}, {self.voxels} voxels"
        if self.method == "sectors":
            return f"{2 * self.sector_planes} sectors, manifold3d {version('manifold3d')}"
        first = f"{2 * self.sector_planes} sectors, " if self.sector_planes else ""
        fine = f"{self.max_pieces} pieces, " if self.max_pieces != DecompositionSettings.max_pieces else ""
        return f"plane cuts, {first}{fine}balance {self.balance:g}, manifold3d {version('manifold3d')}"


@dataclass(frozen=True)
class Decomposition:
    """Convex hulls in the frame of the input, or none and the reason; `dropped` counts slivers left out."""

    shapes: tuple[CollisionShape, ...]
    reason: str = ""
    dropped: int = 0


def decompose(
    body: SimplifiedBody,
    settings: DecompositionSettings,
    work_dir: Path,
    cavities: Sequence[Cavity] = (),
    limits: Limits = CELL,
) -> Decomposition:
    """Hulls of at most 64 points each that fill `body` (`geom.decomposition.simplified_body.simplify_body`), in metres.

    None reaches through a plane that the body rests on. At most `settings.max_hulls`, and never across one of
    `cavities`. Never raises because of the mesh or the library: the reason is in the result. Same input, same hulls.
    Raises OSError when files on the way could not be written or read.
    """
    if settings.method == "sectors":
        parts = _sectors(body, cavities, settings.sector_planes)
        return Decomposition((), parts) if isinstance(parts, str) else _standing(body, parts)
    seeds = body.simplified.decompose()
    if len(seeds) > MOST_SEPARATE_PARTS:
        return Decomposition((), f"{len(seeds)} separate parts, more than {MOST_SEPARATE_PARTS}")
    if settings.method != "cuts":
        hulls = _in_cell(body.simplified, settings, work_dir, limits)
        if isinstance(hulls, str):
            return Decomposition((), hulls)
        seeds = _inside(body.simplified, hulls)
        if not seeds or len(seeds) > MOST_SEPARATE_PARTS:
            return Decomposition((), f"{settings.method} left {len(seeds)} parts")
    if settings.sector_planes and cavities:
        main = max(cavities, key=lambda cavity: cavity.volume_m3)
        place = (main.opening_m - body.centre_m) / body.scale_m
        seeds = [piece for seed in seeds for piece in cut_sectors(seed, main.direction, place, settings.sector_planes)]
    parts = convex_parts(body, seeds, cavities, settings.max_hulls, settings.max_pieces, settings.balance)
    if len(parts) > settings.max_hulls:
        return Decomposition((), f"{len(parts)} hulls, more than {settings.max_hulls}")
    return _standing(body, parts)


def _standing(body: SimplifiedBody, parts: Sequence[FloatArray]) -> Decomposition:
    """The hulls of `parts` (points in metres) without slivers, none through a plane that the body rests on."""
    size = body.size * body.scale_m
    ground = resting_planes(body.in_metres(manifold_arrays(body.full)[0]))
    standing = [hull_within(part, ground) for part in parts]
    shapes = [shape for shape in standing if shape is not None and _is_sound(shape, size)]
    reason = "" if shapes else "all hulls are slivers"
    return Decomposition(tuple(shapes), reason, len(parts) - len(shapes))


def open_through(cavity: Cavity) -> bool:
    """Whether a ball can leave the opening by another way than its mouth: a hole, also one with a wide mouth."""
    return cavity.through or cavity.second_m > 0.0


def _sectors(body: SimplifiedBody, cavities: Sequence[Cavity], planes: int) -> list[FloatArray] | str:
    """Corners (m) of the pieces between planes through the axis of the widest hole, or why their hulls are no fit."""
    through = [cavity for cavity in cavities if open_through(cavity)]
    if not through:
        return "nothing is open from end to end"
    widest = max(through, key=lambda cavity: cavity.diameter_m)
    pieces = cut_sectors(body.full, widest.direction, (widest.opening_m - body.centre_m) / body.scale_m, planes)
    if len(pieces) > 2 * planes:
        return f"{len(pieces)} pieces in {2 * planes} sectors"
    filled = sum(piece.hull().volume() for piece in pieces) / body.full.volume()
    if filled > SECTORS_FILL:
        return f"hulls of sectors have {filled:.3f} times the volume, more than {SECTORS_FILL:g}"
    return [body.in_metres(manifold_arrays(piece.hull())[0]) for piece in pieces]


def _in_cell(
    light: Manifold, settings: DecompositionSettings, work_dir: Path, limits: Limits
) -> list[FloatArray] | str:
    """Corners of the hulls that the library found, or the reason why there are none."""
    if light.num_tri() > MOST_FACES:
        return f"{light.num_tri()} faces, more than {MOST_FACES}"
    points, triangles = manifold_arrays(light)
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        options = {key: np.array(value) for key, value in asdict(settings).items()}
        np.savez(source, allow_pickle=False, points=points, triangles=triangles.astype(np.int32), **options)
        argv = [
            sys.executable,
            "-P",
            "-m",
            "assetkit.colliders.coacd_worker",
            str(source),
            str(target),
            str(DECOMPOSITION_CPU_S),
        ]
        cell = run_cell(argv, limits, env={"OMP_NUM_THREADS": "1"})
        require_storage(cell)
        if cell.status != "ok":
            return f"{settings.method} {_ending(cell, limits)}"
        with np.load(target) as result:
            parts = np.split(result["points"], np.cumsum(result["counts"])[:-1])
    if not all(len(part) and np.isfinite(part).all() for part in parts):
        return f"{settings.method} returned no finite hulls"
    return parts


def _ending(cell: CellResult, limits: Limits) -> str:
    """Why a cell ended without a result, in words."""
    if cell.returncode == -signal.SIGXCPU:
        return f"took more than {DECOMPOSITION_CPU_S} s of processor time"
    return f"timeout after {limits.seconds:g} s" if cell.status == "timeout" else cell.status.replace("_", " ")


def _inside(light: Manifold, hulls: Sequence[FloatArray]) -> list[Manifold]:
    """The body within each hull, less what lies in one before."""
    left, pieces = light, list[Manifold]()
    for corners in hulls:
        hull = Manifold.hull_points(np.ascontiguousarray(corners))
        pieces.append(left ^ hull)
        left -= hull
    crumb = CRUMB_SHARE * light.volume()
    return [part for piece in pieces for part in piece.decompose() if part.volume() > crumb]


def _is_sound(shape: CollisionShape, size: float) -> bool:
    if shape.points is None or shape.triangles is None:
        return False
    thick = thickness(shape.points, shape.triangles) >= LEAST_THICKNESS * size
    return thick and volume(shape.points, shape.triangles) >= LEAST_VOLUME * size**3
