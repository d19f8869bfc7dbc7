"""Processor seconds of the suites of acceptance package by package, and the memory that worlds of the engine keep.

    python -m benchmarks.assets.acceptance LIBRARY [LIBRARY ...] [--most 25] [--worlds 2000]

LIBRARY is a library of released packages, or one package. A row per package: suites at the values of the package, and
what other steps of the engine and the ends of the bounds of friction and mass take in addition (where a suite passes).
Without a role only the suite of every object runs; packages with one have medians of their own.
Seconds are processor time of this one process, without loading libraries and without reading the package. Targets:
medians of 3 s for a rigid prop, 6 s for a mechanism, and in addition at most as much again.

Then `--worlds` worlds are built one after the other from the rigid bodies of these packages, each of a body of its own,
and the body dropped in it for 0.25 s; every `GRASP_EVERY`th world is one of a gripper that closes on the body instead,
which loads an articulated body from files. Memory is the resident set of the process (Linux) after the first tenth of
them, which fills caches, and at the end. Target: it grows by less than 20 MiB.
"""

from __future__ import annotations

import argparse
import gc
import statistics
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import psutil

from assetkit.acceptance.stable_poses import resting_pose
from assetkit.acceptance.suites.margins import variations
from assetkit.acceptance.suites.run import suites_for
from assetkit.acceptance.suites.subject import subject_on_disk
from assetkit.acceptance.suites.suite import NOMINAL, Subject, SuiteRun
from assetkit.acceptance.suites.table import SUITES
from assetkit.library.validate import main_usd_files
from cli.engines import SIMULATOR
from geom.convex.support_function import diagonal
from geom.grasp.gripper import MEDIUM
from geom.pose import DOWN, pose
from schemas.diagnostics import InvalidInput
from sim.grasp_trial import GraspTask
from sim.named_engine import load_engine
from sim.port import DropSettings, Simulator, world_for

TARGET_S = {"rigid": 3.0, "joints": 6.0}
TARGET_GROWTH_MB = 20.0
WARM_SHARE = 0.1  # of the worlds, after which memory is first read
DROP_S = 0.25
GRASP_EVERY = 20


@dataclass(frozen=True)
class Row:
    """One package: processor seconds at its own values and of all other conditions, and suites that failed."""

    name: str
    kind: str
    suites: int
    nominal_s: float
    varied_s: float
    failed: tuple[str, ...]


@dataclass(frozen=True)
class Growth:
    """Resident memory (MiB) after `warm` of `worlds` worlds and after all of them."""

    worlds: int
    warm: int
    before_mb: float
    after_mb: float

    @property
    def grown_mb(self) -> float:
        """How much it grew."""
        return self.after_mb - self.before_mb


def main() -> None:
    """Measure, and print a row per package, the medians, and the growth of memory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("libraries", type=Path, nargs="+", metavar="LIBRARY")
    parser.add_argument("--most", type=int, default=25, help="packages, spread evenly over each library")
    parser.add_argument("--worlds", type=int, default=2000, help="0: no measurement of memory")
    arguments = parser.parse_args()
    files = [file for library in arguments.libraries for file in spread(main_usd_files(library), arguments.most)]
    with load_engine(SIMULATOR)() as simulator:
        subjects = list(read(files, simulator))
        rows: list[Row] = []
        for subject in subjects:
            rows.append(measure(subject, simulator))
            print(line(rows[-1]), flush=True)
        for kind in TARGET_S:
            print_median(kind, "packages", [row for row in rows if row.kind == kind])
            print_median(kind, "with a role", [row for row in rows if row.kind == kind and row.suites > 1])
        rigid = [subject for subject in subjects if not subject.is_articulated]
        if arguments.worlds and rigid:
            grown = memory_growth(rigid, simulator, arguments.worlds)
            print(
                f"{grown.worlds} worlds: {grown.before_mb:.1f} MiB after {grown.warm}, {grown.after_mb:.1f} MiB at the "
                f"end, {grown.grown_mb:+.1f} (target below {TARGET_GROWTH_MB:.0f})"
            )


def spread(files: Sequence[Path], most: int) -> list[Path]:
    """At most `most` of the files, spread evenly over their order."""
    if len(files) <= most:
        return list(files)
    return [files[k] for k in np.linspace(0, len(files) - 1, most).round().astype(int)]


def read(files: Sequence[Path], simulator: Simulator) -> Iterator[Subject]:
    """The subjects of the files; those that cannot be read are named and left out."""
    for file in files:
        try:
            yield subject_on_disk(file, simulator)
        except InvalidInput as invalid:
            print(f"{file.stem:32} left out: {invalid.diagnostic.headline}")


def measure(subject: Subject, simulator: Simulator) -> Row:
    """Runs all suites of the subject, each that passes also under other conditions."""
    nominal_s = varied_s = 0.0
    failed: list[str] = []
    chosen = [suite for suite in suites_for(subject, SUITES) if not suite.obstacle(subject)]
    for suite in chosen:
        started = time.process_time()
        run: SuiteRun = suite.run(subject, simulator, NOMINAL)
        nominal_s += time.process_time() - started
        if not run.passes:
            failed.append(suite.name)
        elif suite.varies:
            started = time.process_time()
            variations(suite, run.tried or subject, simulator)
            varied_s += time.process_time() - started
    kind = "joints" if subject.is_articulated else "rigid"
    return Row(subject.main_file.stem, kind, len(chosen), nominal_s, varied_s, tuple(failed))


def line(row: Row) -> str:
    """A row as text."""
    failed = f"  failed: {', '.join(row.failed)}" if row.failed else ""
    return f"{row.name:32} {row.kind:6} {row.suites} suites {row.nominal_s:7.2f} s {row.varied_s:+7.2f} s{failed}"


def print_median(kind: str, which: str, rows: Sequence[Row]) -> None:
    """Medians and largest figures of packages of one kind, beside the targets; nothing without packages."""
    if not rows:
        return
    nominal, varied = [row.nominal_s for row in rows], [row.varied_s for row in rows]
    print(
        f"{kind}, {len(rows)} {which}: median {statistics.median(nominal):.2f} s (target {TARGET_S[kind]:.0f}), "
        f"most {max(nominal):.2f} s; other conditions: median {statistics.median(varied):+.2f} s "
        f"(target {TARGET_S[kind]:.0f}), most {max(varied):+.2f} s"
    )


def memory_growth(subjects: Sequence[Subject], simulator: Simulator, worlds: int) -> Growth:
    """Resident memory before and after the worlds; see the module."""
    warm = max(1, round(WARM_SHARE * worlds))
    before_mb = 0.0
    for k in range(worlds):
        if k == warm:
            before_mb = _resident_mb()
        # Bodies are compared by identity: each copy makes the simulator build its world anew.
        body = replace(subjects[k % len(subjects)].body)
        size = diagonal(body.shapes)
        X_WA = resting_pose(body, DOWN, gap_m=0.05 * size)
        if k % GRASP_EVERY:
            simulator.drop(body, X_WA, DropSettings(DROP_S, world_for(size)))
        else:
            above = pose(np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 0.5 * size))  # +z of the gripper points down
            simulator.grasp(body, X_WA, GraspTask(above, MEDIUM.opening_m, MEDIUM.force_n, 0.7, MEDIUM))
    return Growth(worlds, warm, before_mb, _resident_mb())


def _resident_mb() -> float:
    gc.collect()
    return psutil.Process().memory_info().rss / 2**20


if __name__ == "__main__":
    main()
