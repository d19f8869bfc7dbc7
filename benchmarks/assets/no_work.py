"""The driver of a batch: peak memory and time by the number of items, `python -m benchmarks.assets.no_work [--real]`.

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
from benchmarks.assets.scale import varied, write_obj
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
    """Prints a line for each number of items, and the ratio of the last peak to the first."""
    peaks: list[float] = []
    for count in counts:
        with tempfile.TemporaryDirectory() as folder:
            argv = [sys.executable, "-m", HERE, str(count), folder, what]
            figures = json.loads(subprocess.run(argv, check=True, capture_output=True, text=True).stdout)
        peaks.append(figures["peak_mib"])
        wall_ms, cpu_ms = (1e3 * figures[name] / count for name in ("wall_s", "cpu_s"))
        print(f"{count} items: {figures['peak_mib']:.1f} MiB at most, {wall_ms:.1f} ms an item (CPU {cpu_ms:.1f})")
    print(f"ratio {peaks[-1] / peaks[0]:.2f}")


def batch_of(count: int, folder: Path, what: str) -> None:
    """One batch of `count` items, "real" or not; prints as JSON the peak memory of the driver (MiB) and its seconds."""
    sources, out = folder / "in", folder / "out"
    sources.mkdir()
    for number in range(count):
        file = sources / f"part_{number:06d}.obj"
        if what == REAL:
            write_obj(file, *varied(number))
        else:
            file.write_text(f"v {number} 0 0\n")
    started = time.monotonic()
    found = listed_sources([sources], out / WORK, root=None, out=out)
    if what == REAL:
        batch = Batch(out, Options(units="m"), SIMULATOR, placement=Placement(JOBS))
    else:
        batch = Batch(out, Options(), "no:engine", HERE, HERE, Placement(JOBS))
    run_batch(found, batch)
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
        case [count, folder, what]:
            batch_of(int(count), Path(folder), what)
        case ["--real"]:
            main(REAL, REAL_COUNTS)
        case [request]:
            item_cell(request)
        case _:
            main("none", COUNTS)
