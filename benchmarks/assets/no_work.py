"""The driver of a batch whose items take no work: peak memory and time, `python -m benchmarks.assets.no_work`.

Each item is a file of one line, and its cell writes a result with three findings at once. Each number of items runs in
a process of its own, from the search for sources to report and catalogue.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from assetkit.batch import result_store
from assetkit.batch.item_cells import WORK, Batch, candidate_of
from assetkit.batch.run_batch import run_batch
from assetkit.options import Options
from assetkit.sources.source_list import listed_sources
from jobs.cache import file_sha256
from jobs.placement import Placement
from schemas.diagnostics import finding
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

HERE = "benchmarks.assets.no_work"
COUNTS = (1000, 20000)
JOBS = 2


def main() -> None:
    """Prints a line for each number of items, and the ratio of the last peak to the first."""
    peaks: list[float] = []
    for count in COUNTS:
        with tempfile.TemporaryDirectory() as folder:
            argv = [sys.executable, "-m", HERE, str(count), folder]
            figures = json.loads(subprocess.run(argv, check=True, capture_output=True, text=True).stdout)
        peaks.append(figures["peak_mib"])
        print(f"{count} items: {figures['peak_mib']:.1f} MiB at most, {1e3 * figures['wall_s'] / count:.1f} ms an item")
    print(f"ratio {peaks[-1] / peaks[0]:.2f}")


def batch_of(count: int, folder: Path) -> None:
    """One batch of `count` items; prints the peak memory of the driver in MiB and its seconds as JSON."""
    sources, out = folder / "in", folder / "out"
    sources.mkdir()
    for number in range(count):
        (sources / f"part_{number:06d}.obj").write_text(f"v {number} 0 0\n")
    started = time.monotonic()
    found = listed_sources([sources], out / WORK, root=None, out=out)
    run_batch(found, Batch(out, Options(), "no:engine", HERE, HERE, Placement(JOBS)))
    peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({"peak_mib": peak_mib, "wall_s": time.monotonic() - started}))


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
        case [request]:
            item_cell(request)
        case [count, folder]:
            batch_of(int(count), Path(folder))
        case _:
            main()
