"""How long a large batch takes on more workers, and what saturates first: a simulation from a measured batch.

    python -m benchmarks.assets.cluster_plan OUT [--items 100000] [--workers 1,10,100,1000] [--write-mb-s 200]

OUT is the folder of a finished ingest with one job per core. Items are drawn from it with replacement, each with the
seconds of its stages and the bytes of its packages. A worker takes the next item when it is free (as Dask does with one
cell per worker), works, writes its package to storage that all share, and hands the result to the driver. Storage and
driver serve one at a time, in order of arrival: storage by its rate, the driver by the measured milliseconds an item
(`python -m benchmarks.assets.no_work`). Failures, transfers of sources and start-up are left out.
"""

from __future__ import annotations

import argparse
import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from assetkit.batch.report_file import read_items
from schemas.arrays import FloatArray

SEED = 20261127
ITEMS, WORKERS = 100_000, (1, 10, 100, 1000)
WRITE_MB_PER_S = 200.0  # a network file system on one 10 Gbit/s link does more, a busy one less: give yours
DRIVER_MS = 3.6  # an item, from no_work on one core; docs/benchmarks.md


@dataclass(frozen=True)
class Measured:
    """Per item of a batch: seconds of each stage (n, s) in the order of `stages`, megabytes written (n,)."""

    stages: tuple[str, ...]
    seconds: FloatArray
    written_mb: FloatArray


@dataclass(frozen=True)
class Forecast:
    """`wall_s` of the whole batch, and the share of it that workers, storage and driver are busy."""

    workers: int
    wall_s: float
    busy: dict[str, float]


def measured(out: Path) -> Measured:
    """The items of a finished batch that were worked on, not taken over from an earlier one."""
    items = [item for item in read_items(out) if item.seconds and not item.cached]
    if not items:
        raise SystemExit(f"{out}: no item was worked on; ingest with --fresh")
    stages = tuple(dict.fromkeys(stage for item in items for stage in item.seconds))
    seconds = np.array([[item.seconds.get(stage, 0.0) for stage in stages] for item in items])
    written = [
        sum(file.stat().st_size for name in item.packages for file in (out / name).rglob("*") if file.is_file())
        for item in items
    ]
    return Measured(stages, seconds, np.array(written) / 1e6)


def forecast(work_s: FloatArray, storage_s: FloatArray, driver_s: float, workers: int) -> Forecast:
    """A batch of items that take these seconds of a worker and of storage (n,), and of the driver for each."""
    count = min(workers, len(work_s))
    working = [(seconds, item) for item, seconds in enumerate(work_s[:count].tolist())]  # (end of the work, item)
    heapq.heapify(working)
    following, storage_free_s, driver_free_s = count, 0.0, 0.0
    while working:
        done_s, item = heapq.heappop(working)
        storage_free_s = max(storage_free_s, done_s) + float(storage_s[item])
        driver_free_s = max(driver_free_s, storage_free_s) + driver_s
        if following < len(work_s):
            heapq.heappush(working, (storage_free_s + float(work_s[following]), following))
            following += 1
    busy = {
        "workers": float(work_s.sum()) / (workers * driver_free_s),
        "storage": float(storage_s.sum()) / driver_free_s,
        "driver": driver_s * len(work_s) / driver_free_s,
    }
    return Forecast(workers, driver_free_s, busy)


def saturation(work_s: FloatArray, storage_s: FloatArray, driver_s: float) -> dict[str, float]:
    """Workers at which storage and driver are busy all the time: mean work of an item over their mean service."""
    services = {"storage": float(storage_s.mean()), "driver": driver_s}
    whole = float(work_s.mean() + storage_s.mean())
    return {name: whole / service for name, service in services.items() if service > 0.0}


def text_of(batch: Measured, forecasts: Sequence[Forecast], limits: dict[str, float]) -> str:
    """Tables in Markdown: seconds of the stages, forecasts, and what saturates first."""
    whole = batch.seconds.sum(axis=1)
    lines = ["| stage | mean s | median s | 95 % s | most s |", "|---|---|---|---|---|"]
    columns = [*zip(batch.stages, batch.seconds.T, strict=True), ("all", whole)]
    for stage, seconds in columns:
        middle, high = np.percentile(seconds, (50.0, 95.0))
        lines.append(f"| {stage} | {seconds.mean():.2f} | {middle:.2f} | {high:.2f} | {seconds.max():.2f} |")
    lines += ["", f"{len(whole)} items, {batch.written_mb.mean():.2f} MB written an item.", ""]
    lines += ["| workers | hours | workers busy | storage busy | driver busy |", "|---|---|---|---|---|"]
    for each in forecasts:
        shares = " | ".join(f"{100.0 * each.busy[name]:.1f} %" for name in ("workers", "storage", "driver"))
        lines.append(f"| {each.workers} | {each.wall_s / 3600.0:.2f} | {shares} |")
    first = min(limits, key=lambda name: limits[name])
    reached = ", ".join(f"{name} at {count:,.0f} workers" for name, count in sorted(limits.items()))
    return "\n".join([*lines, "", f"Busy all the time: {reached}. The {first} saturates first."])


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--items", type=int, default=ITEMS)
    parser.add_argument("--workers", default=",".join(map(str, WORKERS)))
    parser.add_argument("--write-mb-s", type=float, default=WRITE_MB_PER_S)
    parser.add_argument("--driver-ms", type=float, default=DRIVER_MS)
    asked = parser.parse_args()
    batch, driver_s = measured(asked.out), asked.driver_ms / 1000.0
    drawn = np.random.default_rng(SEED).integers(0, len(batch.written_mb), asked.items)
    work_s, storage_s = batch.seconds.sum(axis=1)[drawn], batch.written_mb[drawn] / asked.write_mb_s
    forecasts = [forecast(work_s, storage_s, driver_s, int(count)) for count in asked.workers.split(",")]
    print(text_of(batch, forecasts, saturation(work_s, storage_s, driver_s)))


if __name__ == "__main__":
    main()
