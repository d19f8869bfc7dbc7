"""How cost grows with the number of assets: real ingests of varied copies, and the driver alone with finished items.

`grow` makes scaled and perturbed copies of small meshes, from a seed, and ingests 10, 50, 100 ... of them afresh; then
once more with nothing changed. `driver` gives the command thousands of items that are already done, so that what
remains is its own work: discovery, looking up, report and catalog.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from assetkit.batch import result_store
from assetkit.options import Options
from assetkit.package.record import RECORD, read_record
from assetkit.sources.discover import discover
from benchmarks.running import Cost, run
from geom.mesh import primitives
from schemas.arrays import FloatArray, IntArray
from schemas.report import ReportItem

SEED = 20261121
DRIVER = (1000, 2500, 5000, 10000)
_WHOLE_RUN_S = 7200.0


@dataclass(frozen=True)
class Growth:
    """One run: `what` was done with `assets` of them; `peak_mb` is all its processes together at the worst moment."""

    what: str
    assets: int
    jobs: int
    cpu_s: float
    wall_s: float
    peak_mb: float
    largest_process_mb: float

    @property
    def cpu_ms_per_asset(self) -> float:
        """Milliseconds of processor time an asset."""
        return 1000.0 * self.cpu_s / self.assets


def measure(numbers: Sequence[int], jobs: Sequence[int], out: Path) -> None:
    """Run everything, print the table and the slopes, and write `scale.json` and `scale.md` to `out`."""
    rows = driver(out / "driver") if not numbers or numbers[0] == 0 else []
    rows += [row for n in numbers if n for j in jobs for row in grow(n, j, out / "grow")]
    kept = out / "scale.json"
    earlier = [Growth(**row) for row in json.loads(kept.read_text())] if kept.is_file() else []
    merged = {(r.what, r.assets, r.jobs): r for r in (*earlier, *rows)}
    rows = [merged[key] for key in sorted(merged)]
    kept.write_text(json.dumps([asdict(row) for row in rows], indent=1))
    text = f"{table(rows)}\n\n{slopes(rows)}\n"
    (out / "scale.md").write_text(text)
    print(text)


def grow(count: int, jobs: int, folder: Path) -> list[Growth]:
    """A fresh ingest of `count` varied copies with `jobs` workers, and the same again with nothing changed."""
    shutil.rmtree(folder, ignore_errors=True)
    for index in range(count):
        write_obj(folder / "in" / f"item_{index:04d}.obj", *varied(index))
    fresh = ingest(folder, jobs, "--fresh")
    return [
        row(f"ingest, {jobs} at a time", count, jobs, fresh),
        row(f"again, nothing changed, {jobs} at a time", count, jobs, ingest(folder, jobs)),
    ]


def varied(index: int) -> tuple[FloatArray, IntArray]:
    """Points (n, 3) in metres and triangles of copy `index`: a small mesh, scaled, stretched and dented."""
    rng = np.random.default_rng([SEED, index])
    points, triangles, _ = (
        primitives.cube(0.1),
        primitives.cylinder(0.1, 0.04, 0.04, 12),
        primitives.cylinder(0.1, 0.05, 0.03, 8),
    )[index % 3]
    scale = rng.uniform(0.5, 2.0) * rng.uniform(0.8, 1.25, size=3)
    return points * scale * (1.0 + rng.normal(0.0, 0.01, size=points.shape)), triangles


def write_obj(path: Path, points: FloatArray, triangles: IntArray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    path.write_text("\n".join([*lines, ""]))


def ingest(folder: Path, jobs: int, *more: str) -> Cost:
    argv = [sys.executable, "-P", "-m", "cli.main", "assets", "ingest", str(folder / "in"), "--out"]
    argv += [str(folder / "out"), "--jobs", str(jobs), "--units", "m", "--json", *more]
    return run(argv, env={}, wall_limit_s=_WHOLE_RUN_S)


def driver(folder: Path) -> list[Growth]:
    """The command over 1,000 to 10,000 items that are done: copies of one real package under as many names."""
    shutil.rmtree(folder, ignore_errors=True)
    write_obj(folder / "in" / "item_00000.obj", *varied(0))
    ingest(folder, 1)
    rows: list[Growth] = []
    for count in DRIVER:
        multiply(folder, count)
        rows.append(row("driver alone", count, 1, ingest(folder, 1)))
        unchanged = json.loads((folder / "out" / "report.json").read_text())["totals"]["cached"]
        if unchanged != count:
            raise RuntimeError(f"only {unchanged} of {count} items were taken as done")
    shutil.rmtree(folder)
    return rows


def multiply(folder: Path, count: int) -> None:
    """Make the finished item 0 of `folder` into `count` finished items."""
    source, out, options = folder / "in" / "item_00000.obj", folder / "out", Options(units="m")
    template = read_record(out / "item_00000")
    if template is None:
        raise RuntimeError("the first item made no package")
    for index in range(1, count):
        target = source.with_name(f"item_{index:05d}.obj")
        if not target.exists():
            shutil.copy(source, target)
            package = out / target.stem
            shutil.copytree(out / "item_00000", package)
            record = template.model_copy(update={"asset_id": target.stem})
            (package / RECORD).write_text(record.model_dump_json(indent=1) + "\n")
    first = result_store.read_stored(result_store.result_file(discover([source], root=source.parent)[0], out, options))
    if first is None:
        raise RuntimeError("the first item is not remembered")
    for candidate in discover([source.parent]):
        item = ReportItem(**first.item.model_dump() | {"source": candidate.given, "packages": (candidate.asset_id,)})
        result_store.write_stored(
            result_store.result_file(candidate, out, options), result_store.stored_from(item, candidate, out)
        )


def row(what: str, count: int, jobs: int, cost: Cost) -> Growth:
    if cost.returncode not in {0, 1}:
        raise RuntimeError(cost.output[-2000:])
    return Growth(what, count, jobs, cost.cpu_s, cost.wall_s, cost.together_mb, cost.process_mb)


def table(rows: Sequence[Growth]) -> str:
    headings = ("what", "assets", "CPU s", "CPU ms an asset", "wall s", "peak MiB", "largest process MiB")
    heading = f"| {' | '.join(headings)} |\n|{'---|' * len(headings)}\n"
    return heading + "\n".join(
        f"| {r.what} | {r.assets} | {r.cpu_s:.1f} | {r.cpu_ms_per_asset:.1f} | {r.wall_s:.1f} | {r.peak_mb:.0f} "
        f"| {r.largest_process_mb:.0f} |"
        for r in rows
    )


def slopes(rows: Sequence[Growth]) -> str:
    """The exponent e of cost ~ assets^e, fitted to CPU time beyond a fixed start-up, for each kind of run."""
    texts = []
    for what in dict.fromkeys(r.what for r in rows):
        group = [r for r in rows if r.what == what]
        if len(group) < 3:
            continue
        counts, cpu = np.array([r.assets for r in group]), np.array([r.cpu_s for r in group])
        start, slope = np.linalg.lstsq(np.stack([np.ones(len(counts)), counts], axis=1), cpu, rcond=None)[0]
        last = (cpu[-1] - cpu[-2]) / (counts[-1] - counts[-2])
        whole = (cpu[-1] - cpu[0]) / (counts[-1] - counts[0])
        texts.append(
            f"- {what}: {start:.1f} s + {1000 * slope:.1f} ms an asset (least squares); the last step costs "
            f"{last / whole:.2f} times the average"
        )
    return "\n".join(texts)
