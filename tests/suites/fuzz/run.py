"""Damaged copies of real files through every reader: each must end in a value or a code, within limits.

    python -m tests.suites.fuzz.run [--files 20] [--mutations 200] [--format F ...] [--seed S] [--out DIR] [--jobs N]

Case I of a file with seed S is the same damage on every run. Prints a row per format and every case that raised, broke
a promise, opened a file outside its folder, or went beyond the limits; such inputs are written to DIR. Exit code 1
when there is one.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from assetkit.batch.item_cells import ENVIRONMENT
from jobs.cell import CellResult, Limits
from jobs.schedule import run_all
from jobs.warm import run_module, warm_cells
from tests.suites.fuzz.cases import make_case
from tests.suites.fuzz.cell import WAITING_FACTOR
from tests.suites.fuzz.readers.by_format import READERS
from tests.suites.fuzz.seeds import ROOT, Seed, seeds_of
from tests.suites.fuzz.table import Row, Tally, table

CASE_S = 60.0  # of processor time for one input; they are small
MEMORY_MB = 6144  # address space of a cell, of which libraries map about 2 GiB before they read anything
WITHOUT_PEERS = tuple(name for name in READERS if name != "blend")  # Blender is a program of its own
CELL = "tests.suites.fuzz.cell"
# Arrow's allocator starts a thread on import, and a process with threads cannot be forked (jemalloc(3)).
WITHOUT_THREADS = {"JE_ARROW_MALLOC_CONF": "background_thread:false"}


@dataclass(frozen=True)
class Run:
    """Settings of a run: `stream` names the random stream, `keep` the folder of inputs that failed."""

    stream: str
    mutations: int
    scratch: Path
    keep: Path | None = None
    seconds: float = CASE_S
    memory_mb: int = MEMORY_MB
    cell: str = CELL

    @property
    def environment(self) -> dict[str, str]:
        """The environment of cells."""
        return {**ENVIRONMENT, **WITHOUT_THREADS, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}


@dataclass
class _Progress:
    """The cases of one seed that are left, and rows of those that have ended."""

    left: list[int]
    rows: list[Row] = field(default_factory=list)


def fuzz(seeds: Sequence[Seed], run: Run, jobs: int = 1) -> Iterator[Row]:
    """A row per case, seed after seed; cells are forks of one process that has loaded all readers."""
    with warm_cells(run.cell, env=run.environment):
        for _, rows in run_all(lambda seed: _of_seed(seed, run), seeds, jobs=jobs):
            yield from rows


def _of_seed(seed: Seed, run: Run) -> list[Row]:
    progress = _Progress(list(range(run.mutations)))
    place = Path(tempfile.mkdtemp(prefix=f"{seed.format}-", dir=run.scratch))
    try:
        while progress.left:
            _one_cell(seed, run, place, progress)
    finally:
        shutil.rmtree(place, ignore_errors=True)
    if run.keep is not None:
        for row in progress.rows:
            if row.failure:
                _keep(seed, run, row, run.keep)
    return progress.rows


def _one_cell(seed: Seed, run: Run, place: Path, progress: _Progress) -> None:
    """Run a cell as far as it gets; the case that ended it has a row as well."""
    notes_file = place / "notes.jsonl"
    notes_file.unlink(missing_ok=True)
    task = {
        "format": seed.format,
        "folder": str(seed.folder),
        "file": str(seed.file),
        "place": str(place),
        "numbers": progress.left,
        "stream": run.stream,
        "seconds": run.seconds,
    }
    (place / "task.json").write_text(json.dumps(task))
    limits = Limits(seconds=(WAITING_FACTOR * run.seconds + 10.0) * len(progress.left), memory_mb=run.memory_mb)
    result = run_module(run.cell, [str(place / "task.json"), str(notes_file)], limits, env=run.environment)
    lines = [json.loads(line) for line in notes_file.read_text().splitlines()] if notes_file.exists() else []
    before = len(progress.left)
    for line in lines:
        if "end" in line:
            progress.rows.append(Row.from_note(seed, line))
            progress.left.remove(line["end"])
    if progress.left and lines and "start" in lines[-1]:
        progress.rows.append(_ended_by(seed, lines[-1], result))
        progress.left.remove(lines[-1]["start"])
    if len(progress.left) == before:
        raise RuntimeError(f"the cell of {seed.name} did nothing: {result.status} {result.output[-2000:]}")


def _ended_by(seed: Seed, line: dict[str, object], result: CellResult) -> Row:
    """The row of a case that took its cell along."""
    status = "timeout" if -result.returncode in (signal.SIGALRM, signal.SIGPROF) else result.status
    return Row(
        seed.format, seed.name, int(str(line["start"])), str(line["done"]), ended=status, trace=result.output[-1500:]
    )


def _keep(seed: Seed, run: Run, row: Row, keep: Path) -> None:
    place = keep / f"{seed.format}_{seed.folder.name}_{seed.file.stem}_{row.number}"
    shutil.rmtree(place, ignore_errors=True)
    make_case(f"{run.stream}:{row.number}", seed, place)
    (place / "row.txt").write_text(f"{row.done}\n{row.failure}\n{row.trace}\n{row.broken}\n", errors="replace")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; exit code 1 where an input failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=20, help="real files per format, as far as there are so many")
    parser.add_argument("--mutations", type=int, default=200, help="damaged copies of each")
    parser.add_argument("--format", action="append", choices=sorted(READERS), help="only this; may be repeated")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("fuzz_out"), help="where inputs that failed go")
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args(argv)
    tally = Tally()
    with tempfile.TemporaryDirectory(prefix="fuzz-") as scratch:
        run = Run(f"{arguments.seed}", arguments.mutations, Path(scratch), arguments.out)
        for name in arguments.format or WITHOUT_PEERS:
            seeds = seeds_of(name, run.scratch, arguments.files)
            started = time.monotonic()
            for row in fuzz(seeds, run, arguments.jobs):
                tally.add(row)
                if row.failure:
                    print(row.text(), flush=True)
            print(f"{name}: {len(seeds)} files in {time.monotonic() - started:.0f} s", flush=True)
    print(table(tally))
    return int(tally.failures > 0)


if __name__ == "__main__":
    sys.exit(main())
