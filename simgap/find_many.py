"""The search for many measurement folders: each in a cell of its own, on this machine or on a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jobs.cell import Limits
from jobs.json_cell import ONE_THREAD, ask
from jobs.placement import Placement, cells_at
from jobs.schedule import run_all
from schemas.diagnostics import Diagnostic
from schemas.sim_gap.report import Verdict

LIMITS = Limits(seconds=4 * 3600.0, memory_mb=8192)  # a long recording of a chain takes tens of minutes
WORKER = "simgap.find_worker"


@dataclass(frozen=True)
class FoundIn:
    """What the search found in one measurement folder: a verdict with the report in `out`, or why it was refused."""

    measurement: Path
    out: Path
    verdict: Verdict | None = None
    refused: Diagnostic | None = None


def find_many(
    measurements: Sequence[Path], out: Path, *, engine: str, placement: Placement, quick: bool = False
) -> Iterator[FoundIn]:
    """Search each folder as `simgap.run.find` does, and yield what was found as folders are finished.

    The report of a folder is in the folder of its name below `out`; namesakes have a number. Answers that are there
    are not worked out again. Raises ClusterUnusable as `jobs.placement.cells_at` does.
    """
    out.mkdir(parents=True, exist_ok=True)
    shared = {"engine": engine, "quick": quick}
    folders = dict(zip(measurements, folder_names(measurements), strict=True))

    def search(measurement: Path) -> dict[str, Any]:
        place = out / folders[measurement]
        request = {**shared, "measurement": str(measurement.absolute()), "out": str(place.absolute())}
        return ask(WORKER, request, LIMITS, measurement.name, stopped="gap/stopped", scratch=out)

    with cells_at(placement, WORKER, env=ONE_THREAD, shared=[out], needed=measurements) as jobs:
        for measurement, answer in run_all(search, measurements, jobs=jobs):
            place = out / folders[measurement]
            if "refused" in answer:
                yield FoundIn(measurement, place, refused=Diagnostic.model_validate(answer["refused"]))
            else:
                yield FoundIn(measurement, place, verdict=Verdict.model_validate(answer["verdict"]))


def folder_names(measurements: Sequence[Path]) -> list[str]:
    """A name for each folder, in order: its own, with a number from the second one of a name on."""
    names: list[str] = []
    for measurement in measurements:
        name = measurement.absolute().name
        number = next(n for n in range(1, len(names) + 2) if (name if n == 1 else f"{name}_{n}") not in names)
        names.append(name if number == 1 else f"{name}_{number}")
    return names
