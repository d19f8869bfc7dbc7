"""Collision shapes of every mesh in a folder: figures against the strict bar, and plain CoACD beside them.

    python -m benchmarks.assets.collision ASSETS_DIR OUT_DIR [--only TEXT] [--plain TEXT ...] [--table]

Each distinct object that ingest accepts is read, made canonical and given colliders; one row per object goes to
`OUT_DIR/collision.csv` at once, so that an interrupted run goes on where it stopped. `--plain` also runs CoACD with its
defaults on the objects whose name holds one of the texts (`OUT_DIR/plain.csv`). `--table` prints both as Markdown.
CPU seconds of one core, all child processes included.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

from assetkit.acceptance.body_checks import MAX_HULL_POINTS, MAX_SHAPES
from assetkit.colliders.choose import PARTS, Colliders, choose_colliders, failed_candidate
from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource
from benchmarks.assets.collision_table import print_tables
from geom.convex.hull import hull_shape
from geom.decomposition.fidelity import measure_fidelity
from geom.features.cavities import find_cavities
from jobs.cell import Limits, run_cell
from schemas.physics import Fidelity, Solid

PLAIN_LIMIT = Limits(seconds=900.0, memory_mb=8192)
PLAIN = """
import sys, time, numpy, coacd
job = numpy.load(sys.argv[1])
coacd.set_log_level("error")
started = time.process_time()
parts = coacd.run_coacd(coacd.Mesh(job["points"], job["triangles"]))
seconds = time.process_time() - started
points = [p for p, _ in parts]
numpy.savez(sys.argv[2], points=numpy.concatenate(points), counts=[len(p) for p in points], seconds=seconds)
"""


@dataclass(frozen=True)
class Row:
    """One object and its colliders; distances in percent of the diagonal. `fails` is empty when the bar is met."""

    name: str
    kind: str
    faces: int
    method: str
    hulls: int
    points: int
    largest_hull: int
    volume_ratio: float
    outside_p95: float
    missing_p95: float
    outside_max: float
    missing_max: float
    openings: int
    kept: str
    cpu_s: float
    fails: str


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--plain", nargs="*", default=[])
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    ours, plain = arguments.out / "collision.csv", arguments.out / "plain.csv"
    if not arguments.table:
        done = {table: {row["name"] for row in rows_of(table)} for table in (ours, plain)}
        for name, solid in solids(arguments.assets, arguments.only):
            if name not in done[ours]:
                append(ours, measured(name, solid))
            if name not in done[plain] and any(text in name for text in arguments.plain):
                append(plain, plain_coacd(name, solid))
    print_tables(rows_of(ours), rows_of(plain))


def solids(assets: Path, only: str) -> Iterator[tuple[str, Solid]]:
    """Name and solid of every object that ingest accepts, each form once, whatever its file format, unit and pose."""
    seen: set[tuple[object, ...]] = set()
    for candidate in discover([assets]):
        objects = ReadSource().run(candidate, Options()).objects
        for number, item in enumerate(objects, start=1):
            name = f"{candidate.asset_id}-{number:02d}" if len(objects) > 1 else candidate.asset_id
            made = canonicalize(item, candidate.file.path.name, Options()).value if only in name else None
            if made is None:
                continue
            size = np.sort(np.ptp(made.solid.points, axis=0))
            form = (made.solid.kind, len(made.solid.triangles), *np.round(size / np.linalg.norm(size), 3))
            if form not in seen:
                seen.add(form)
                yield name, made.solid


def measured(name: str, solid: Solid) -> Row:
    """The row of the colliders that ingest would give to `solid`."""
    with tempfile.TemporaryDirectory() as folder:
        started = cpu_seconds()
        chosen = choose_colliders(solid, Path(folder))
        seconds = cpu_seconds() - started
    return row_of(name, solid, chosen, seconds)


def row_of(name: str, solid: Solid, chosen: Colliders, seconds: float) -> Row:
    figures = next(c for c in chosen.candidates if c.method == chosen.method)
    largest = max((len(s.points) for s in chosen.shapes if s.points is not None), default=0)
    return Row(
        name=name,
        kind=solid.kind,
        faces=len(solid.triangles),
        method=chosen.method,
        hulls=figures.shapes,
        points=figures.vertices,
        largest_hull=largest,
        volume_ratio=round(np.nan if figures.volume_ratio is None else figures.volume_ratio, 3),
        outside_p95=round(100.0 * figures.outside_p95, 2),
        missing_p95=round(100.0 * figures.missing_p95, 2),
        outside_max=round(100.0 * figures.outside_max, 2),
        missing_max=round(100.0 * figures.missing_max, 2),
        openings=len(chosen.cavities),
        kept="" if figures.cavity_kept is None else str(figures.cavity_kept),
        cpu_s=round(seconds, 2),
        fails="; ".join(missed(figures, largest)),
    )


def missed(figures: Fidelity, largest_hull: int) -> list[str]:
    """What of the strict bar is not met."""
    low, high = PARTS.volume
    ratio = figures.volume_ratio
    violated = []
    if max(figures.outside_p95, figures.missing_p95) > PARTS.p95:
        violated.append("surface")
    if ratio is not None and not low <= ratio <= high:
        violated.append("volume")
    if figures.cavity_kept is False:
        violated.append("leak" if figures.cavity_open else "opening")
    if figures.shapes > MAX_SHAPES or largest_hull > MAX_HULL_POINTS:
        violated.append("size")
    return violated


def plain_coacd(name: str, solid: Solid) -> Row:
    """The row of `coacd.run_coacd` with all its defaults, hulls as they come; no hulls when it does not finish."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(source, points=solid.points, triangles=solid.triangles)
        started = cpu_seconds()
        argv = [sys.executable, "-c", PLAIN, str(source), str(target)]
        result = run_cell(argv, PLAIN_LIMIT, env={"OMP_NUM_THREADS": "1"})
        seconds = cpu_seconds() - started
        parts: list[np.ndarray] = []
        if result.status == "ok":
            with np.load(target) as found:
                seconds = float(found["seconds"])
                parts = np.split(found["points"], np.cumsum(found["counts"])[:-1])
    shapes = tuple(s for s in (hull_shape(part, len(part)) for part in parts) if s is not None)
    cavities = find_cavities(solid)
    figures = measure_fidelity("plain", shapes, solid, cavities) if shapes else failed_candidate("plain", result.status)
    return row_of(name, solid, Colliders("plain", shapes, (figures,), cavities), seconds)


def cpu_seconds() -> float:
    """Processor time of this process and its finished children."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def rows_of(table: Path) -> list[dict[str, str]]:
    """The rows written so far."""
    if not table.exists():
        return []
    with table.open(newline="") as file:
        return list(csv.DictReader(file))


def append(table: Path, row: Row) -> None:
    """Write one row now, and show it."""
    is_new = not table.exists()
    with table.open("a", newline="") as file:
        writer = csv.DictWriter(file, [f.name for f in fields(Row)])
        if is_new:
            writer.writeheader()
        writer.writerow(asdict(row))
    print(*asdict(row).values(), flush=True)


if __name__ == "__main__":
    main()
