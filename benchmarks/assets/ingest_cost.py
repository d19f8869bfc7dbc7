"""Processor seconds and USD openings of an ingest, file by file, in two checkouts in turn.

    python -m benchmarks.assets.ingest_cost BEFORE AFTER --assets ASSETS [--rounds 3] [--only WORD]

BEFORE and AFTER are checkouts of Mana; ASSETS holds the shared dev assets. One warm process per checkout ingests each
of the 20 `FILES` without stored results. Both get every file in turn, first the one, then the other, so that the load
of the machine meets them alike. Processor time counts the process, its fork server and all cells (Linux, 10 ms steps);
each figure is the median over `--rounds`. What is done once for a batch (libraries, a ready studio) has its own row.

One more round counts openings: calls of `Usd.Stage.Open` on a file or on a layer in memory, and of
`Sdf.Layer.OpenAsAnonymous`, by whatever code.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import statistics
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import IO
from unittest import mock

FILES = (
    "glb/khr_duck_glb/Duck.glb",
    "glb/sapien_water_bottle_glb/water_bottle.glb",
    "glb/habitat_chair_glb/chair.glb",
    "glb/gt_boxmeshopt_glb/BoxMeshopt.glb",
    "gltf/drake_bin/bin.gltf",
    "gltf/gt_boxdraco/BoxDraco.gltf",
    "gltf/khr_duck_specgloss/Duck.gltf",
    "dae/khr_duck_dae/Duck.dae",
    "dae/as_cube_utf8bom_dae/cube_UTF8BOM.dae",
    "usd/tus_suzanne_usdc/suzanne.usdc",
    "usd/tus_texturedcube_usda/texturedcube.usda",
    "usd/uwg_chess_king/King.usd",
    "usdz/tus_cat_plane_usdz/texture-cat-plane.usdz",
    "stl/tm_featuretype_stl/featuretype.STL",
    "stl/tm_20mm-xyz-cube_stl/20mm-xyz-cube.stl",
    "ply/tm_reference_ply/reference.ply",
    "obj/tm_fuze_obj/fuze.obj",
    "obj/as_spider_obj/spider.obj",
    "obj/tm_chair_model_obj/chair_model.obj",
    "obj/ycb_003_cracker_box_obj/textured_simple_reoriented.obj",
)
_COUNTED = "counted_preload"  # A copy of this file under this name is the preloaded module of a counting worker.
_OPENINGS = "MANA_BENCH_OPENINGS"  # Names the file that openings are appended to.
_KINDS = ("stage from a file", "stage from a layer", "layer alone")
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Row:
    """One file: seconds of processor time and counts of openings by kind, before and after."""

    file: str
    before_s: float
    after_s: float
    before: Counter[str]
    after: Counter[str]


class Worker:
    """A process that ingests one file after the other with the code of one checkout."""

    def __init__(self, checkout: Path, folder: Path, openings: Path | None = None) -> None:
        self._openings = openings
        code = folder / "code"
        code.mkdir(parents=True)
        (code / f"{_COUNTED}.py").write_bytes(Path(__file__).read_bytes())
        environment = {**os.environ, "PYTHONPATH": f"{checkout}{os.pathsep}{code}"}
        if openings is not None:
            environment[_OPENINGS] = str(openings)
        command = [sys.executable, "-P", str(code / f"{_COUNTED}.py"), "--worker", str(folder / "library")]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment, cwd=folder
        )

    def ingest(self, file: Path) -> tuple[float, Counter[str]]:
        """Seconds of processor time of one ingest, and the openings by kind if they are counted."""
        if self._openings is not None:
            self._openings.write_text("")
        before_s = processor_s(self._process.pid)
        stdin, stdout = self._process.stdin, self._process.stdout
        if stdin is None or stdout is None:
            raise RuntimeError("the worker has no pipes")
        stdin.write(f"{file}\n")
        stdin.flush()
        if stdout.readline().strip() != "done":
            raise RuntimeError(f"the worker failed on {file}")
        spent_s = processor_s(self._process.pid) - before_s
        lines = self._openings.read_text().splitlines() if self._openings is not None else []
        return spent_s, Counter(lines)

    def close(self) -> None:
        """End the process and wait for it."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait()


def main() -> None:
    """Measure, and print one line per file and the sums."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path, metavar="BEFORE")
    parser.add_argument("after", type=Path, metavar="AFTER")
    parser.add_argument("--assets", type=Path, required=True)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="", help="files whose path holds this word")
    arguments = parser.parse_args()
    files = [arguments.assets / name for name in FILES if arguments.only in name]
    with tempfile.TemporaryDirectory(prefix="mana-bench") as place:
        checkouts = [arguments.before.absolute(), arguments.after.absolute()]
        rows = measure(checkouts, files, arguments.rounds, Path(place))
    print_table(rows)


def measure(checkouts: list[Path], files: list[Path], rounds: int, place: Path) -> list[Row]:
    """A row per file; files outermost, so that both checkouts get the same file under the same load."""
    workers = [Worker(checkout, place / f"timed{i}") for i, checkout in enumerate(checkouts)]
    loading_s = [worker.ingest(files[0])[0] for worker in workers]
    spent = {file: [[worker.ingest(file)[0] for worker in workers] for _ in range(rounds)] for file in files}
    for worker in workers:
        worker.close()
    before_s, after_s = ({f: statistics.median(trial[i] for trial in spent[f]) for f in files} for i in (0, 1))
    once_s = loading_s[0] - before_s[files[0]], loading_s[1] - after_s[files[0]]
    counters = [Worker(c, place / f"counted{i}", place / f"openings{i}") for i, c in enumerate(checkouts)]
    for counter in counters:
        counter.ingest(files[0])
    rows = [Row("once for a batch", *once_s, Counter(), Counter())]
    for file in files:
        before, after = (counter.ingest(file)[1] for counter in counters)
        rows.append(Row(file.name, before_s[file], after_s[file], before, after))
    for counter in counters:
        counter.close()
    return rows


def print_table(rows: list[Row]) -> None:
    """One line for what is done once, one per file, then sums, and the median of the ratios of files."""
    print(f"{'file':24} {'before s':>9} {'after s':>8} {'ratio':>6}   openings: {', '.join(_KINDS)}; before -> after")
    for row in rows:
        counts = ", ".join(f"{row.before[kind]} -> {row.after[kind]}" for kind in _KINDS)
        ratio = row.after_s / row.before_s
        print(f"{row.file:24} {row.before_s:9.2f} {row.after_s:8.2f} {ratio:6.2f}   {counts}")
    before_s, after_s = sum(r.before_s for r in rows), sum(r.after_s for r in rows)
    counts = ", ".join(f"{sum(r.before[k] for r in rows)} -> {sum(r.after[k] for r in rows)}" for k in _KINDS)
    print(f"{'sum':24} {before_s:9.2f} {after_s:8.2f} {after_s / before_s:6.2f}   {counts}")
    print(f"median ratio {statistics.median(r.after_s / r.before_s for r in rows[1:]):.2f}")


def processor_s(root: int) -> float:
    """User and system time of a process, its living descendants, and the children that each has waited for."""
    processes: dict[int, tuple[int, int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:  # It ended meanwhile.
                continue
            processes[int(entry.name)] = (int(fields[1]), sum(int(fields[i]) for i in (11, 12, 13, 14)))
    ticks, members = 0, {root}
    while members:
        ticks += sum(processes[pid][1] for pid in members if pid in processes)
        members = {pid for pid, (parent, _) in processes.items() if parent in members}
    return ticks / _TICKS_PER_S


def serve(library: Path, requests: IO[str]) -> None:
    """Ingest every file named on a line of `requests`, and print a line after each."""
    from assetkit.batch import item_cells
    from assetkit.options import Options
    from assetkit.sources.discover import discover
    from cli.engines import SIMULATOR
    from jobs.warm import warm_cells

    preload = _COUNTED if _OPENINGS in os.environ else item_cells.PRELOAD
    batch = item_cells.Batch(library, Options(), SIMULATOR, fresh=True, preload=preload)
    # One fork server for all files: `run_items` would start another one for each.
    with (
        warm_cells(preload, env=item_cells.ENVIRONMENT | {"MANA_ENGINE": SIMULATOR, "MANA_STUDIO": "ready"}),
        mock.patch.object(item_cells, "warm_cells", return_value=contextlib.nullcontext()),
    ):
        for line in requests:
            items = list(item_cells.run_items(discover([Path(line.strip())]), batch))
            made = ", ".join(f"{item.outcome.value} {' '.join(item.codes)}" for item in items)
            print("done" if all(item.packages for item in items) else f"no package: {made}", flush=True)


def count_openings(log: Path) -> None:
    """Append a line to `log` for every opening in this process and its forks."""
    from pxr import Sdf, Usd

    open_stage, open_layer = Usd.Stage.Open, Sdf.Layer.OpenAsAnonymous

    def note(kind: str) -> None:
        with log.open("a") as lines:
            lines.write(f"{kind}\n")

    def stage_opened(source: object, *more: object) -> object:
        note(_KINDS[0] if isinstance(source, str) else _KINDS[1])
        return open_stage(source, *more)

    def layer_opened(*where: object, **how: object) -> object:
        note(_KINDS[2])
        return open_layer(*where, **how)

    Usd.Stage.Open, Sdf.Layer.OpenAsAnonymous = stage_opened, layer_opened


if __name__ == _COUNTED:
    import assetkit.batch.preload  # noqa: F401

    count_openings(Path(os.environ[_OPENINGS]))
if __name__ == "__main__":
    if sys.argv[1:2] == ["--worker"]:
        serve(Path(sys.argv[2]), sys.stdin)
    else:
        main()
