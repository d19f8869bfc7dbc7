"""The driver of a batch: peak memory and time by the number of items.

    python -m benchmarks.assets.no_work [--real] [COUNT COUNT]

Each item is a file of one line, and its cell writes a result with three findings at once. With `--real` items are small
meshes (`benchmarks.assets.scale.varied`) that become packages. Each number of items runs in a process of its own, from
the search for sources to report and catalogue.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from assetkit.batch import result_store
from assetkit.batch.item_cells import WORK, Batch, candidate_of
from assetkit.batch.run_batch import run_batch
from assetkit.options import Options
from assetkit.sources.source_list import listed_sources
from cli.engines import SIMULATOR
from jobs.cache import file_sha256
from jobs.placement import Placement
from schemas.diagnostics import finding
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

HERE = "benchmarks.assets.no_work"
COUNTS, REAL_COUNTS = (1000, 20000), (100, 1000)
JOBS = 2
REAL = "real"


def main(what: str, counts: Sequence[int]) -> None:
    """Prints a line for each number of items, then the ratio of the last peak to the first and the cost of one more."""
    rows: list[dict[str, float]] = []
    for count in counts:
        with tempfile.TemporaryDirectory() as folder:
            write_sources(Path(folder) / "in", count, what)
            argv = [sys.executable, "-m", HERE, folder, what]
            rows.append(json.loads(subprocess.run(argv, check=True, capture_output=True, text=True).stdout))
        row = rows[-1]
        each_ms = 1e3 * row["wall_s"] / count
        print(f"{count} items: {row['peak_mib']:.1f} MiB at most, {each_ms:.1f} ms an item, CPU {row['cpu_s']:.1f} s")
    first, last = rows[0], rows[-1]
    one_more_ms = 1e3 * (last["cpu_s"] - first["cpu_s"]) / (counts[-1] - counts[0])
    print(f"ratio of peaks {last['peak_mib'] / first['peak_mib']:.2f}, CPU of one more item {one_more_ms:.2f} ms")


def write_sources(folder: Path, count: int, what: str) -> None:
    """Writes the sources, outside of the process that is measured."""
    from benchmarks.assets.scale import varied, write_obj

    folder.mkdir()
    for number in range(count):
        file = folder / f"part_{number:06d}.obj"
        if what == REAL:
            write_obj(file, *varied(number))
        else:
            file.write_text(f"v {number} 0 0\n")


def batch_of(folder: Path, what: str) -> None:
    """One batch, "real" or not; prints as JSON the peak memory of the driver (MiB) and its seconds."""
    out, started = folder / "out", time.monotonic()
    sources = listed_sources([folder / "in"], out / WORK, root=None, out=out)
    if what == REAL:
        batch = Batch(out, Options(units="m"), SIMULATOR, placement=Placement(JOBS))
    else:
        batch = Batch(out, Options(), "no:engine", HERE, HERE, Placement(JOBS))
    run_batch(sources, batch)
    spent = resource.getrusage(resource.RUSAGE_SELF)
    figures = {"peak_mib": spent.ru_maxrss / 1024, "cpu_s": spent.ru_utime + spent.ru_stime}
    print(json.dumps(figures | {"wall_s": time.monotonic() - started}))


def item_cell(request_file: str) -> None:
    """A cell that finds three things and does no work."""
    request = json.loads(Path(request_file).read_text())
    candidate = candidate_of(request)
    findings = tuple(finding("asset/small-holes", f"hole {number} was closed", value=1.0) for number in range(3))
    item = ReportItem(
        source=candidate.given,
        outcome=ItemOutcome.REVIEW,
        codes=tuple(each.code for each in findings),
        diagnostics=findings,
    )
    stored = result_store.StoredResult(item=item, main_sha256=file_sha256(candidate.file.path))
    result_store.write_stored(Path(request["note"]), stored)


if __name__ == "__main__":
    match sys.argv[1:]:
        case [folder, "real" | "none" as what]:
            batch_of(Path(folder), what)
        case ["--real", *counts]:
            main(REAL, [int(count) for count in counts] or REAL_COUNTS)
        case [request] if request.endswith(".json"):
            item_cell(request)
        case counts:
            main("none", [int(count) for count in counts] or COUNTS)
