"""A batch from sources to a library: discovery, the lock of the folder, one item per source, report and catalogue."""

from __future__ import annotations

import shutil
import sqlite3
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from assetkit.batch.arrivals import PassScope
from assetkit.batch.finished_items import FinishedItems
from assetkit.batch.item_cells import DEFAULT_LIMITS, WORK, Batch, Sources, default_jobs, numbered_items
from assetkit.batch.report import write_report
from assetkit.batch.report_file import FinishedBatch
from assetkit.library import catalog
from assetkit.library.near_duplicates import refresh_near_duplicates
from assetkit.options import Options
from assetkit.sources.source_list import listed_sources
from assetkit.storage import failure_of_folder
from jobs.cell import Limits
from jobs.lock import FolderUnusable, exclusive
from jobs.placement import Placement
from schemas.report import ReportItem

# Called with (items finished, items in all, the item that has just finished or None at the start).
Progress = Callable[[int, int, ReportItem | None], None]


def ingest(
    sources: Sequence[str | Path],
    out: str | Path,
    *,
    engine: str,
    options: Options | None = None,
    root: str | Path | None = None,
    placement: Placement | None = None,
    limits: Limits = DEFAULT_LIMITS,
    resume: bool = False,
    fresh: bool = False,
    selection: PassScope | None = None,
    progress: Progress | None = None,
) -> FinishedBatch:
    """Turn source files (or folders of them) into packages in the folder `out`, and return the figures of the batch.

    `engine` names the simulator that tries each package, as `"module:attribute"`; PyBullet is
    `"sim.bullet.simulator:BulletSimulator"`. `options` hold what the caller knows of the sources: units, up axis, role,
    category, licence. `root` is the folder that references may not leave. Cells run at `placement`, by default one per
    core of this machine, each under `limits`. Unchanged sources are taken from the store; `resume` also keeps items
    that crashed or timed out, `fresh` makes all anew. With a `selection` only a part of the sources is taken up, the
    report keeps the earlier items of the others. `out` holds packages, `report.json`, `report.html` and
    `catalog.sqlite` afterwards, also after Ctrl-C (`interrupted` in the report).

    Raises FolderInUse while another process writes into `out`, FolderUnusable where nothing (more) can be written,
    ClusterUnusable where no worker can be used, and InvalidInput when the file of people's decisions in `out` cannot
    be read.
    """
    out = Path(out)
    with exclusive(out):
        given = tuple(Path(source) for source in sources)
        source_list = listed_sources(given, out / WORK, root=None if root is None else Path(root), out=out)
        batch = Batch(
            out=out,
            options=options or Options(),
            engine=engine,
            placement=placement or Placement(default_jobs()),
            limits=limits,
            resume=resume,
            fresh=fresh,
            given=given,
        )
        try:
            return run_batch(source_list, batch, progress, selection)
        except (OSError, sqlite3.OperationalError) as error:
            reason = failure_of_folder(error, out)
            if reason is None:
                raise
            advice = "what is finished is kept, and the same command continues"
            raise FolderUnusable(f"cannot write into '{out}': {reason}; {advice}") from error
        finally:
            shutil.rmtree(out / WORK, ignore_errors=True)


def run_batch(
    candidates: Sources, batch: Batch, progress: Progress | None = None, selection: PassScope | None = None
) -> FinishedBatch:
    """Run all items, then write report and catalogue, also after Ctrl-C. The caller holds the lock of the folder.

    Sources and finished items lie on disk, so memory does not grow with their number.
    """
    started = time.monotonic()
    interrupted = False
    report_progress = progress or (lambda done, total, item: None)
    chosen = None if selection is None else selection.split(candidates)
    count = len(candidates if chosen is None else chosen)
    report_progress(0, count, None)
    with FinishedItems(batch.out / WORK, len(candidates)) as finished:
        for position, item in () if chosen is None else chosen.earlier_items():
            finished.add(position, item)
        earlier = len(finished)
        try:
            for number, item in numbered_items(candidates if chosen is None else chosen, batch):
                finished.add(number if chosen is None else chosen.positions[number], item)
                report_progress(len(finished) - earlier, count, item)
        except KeyboardInterrupt:
            interrupted = True
        totals = finished.totals(wall_seconds=time.monotonic() - started)
        result = FinishedBatch(batch.out, totals, finished.reasons(), interrupted)
        write_report(result, finished)
    catalog.update(batch.out)
    if not interrupted:
        with suppress(KeyboardInterrupt):  # The next batch compares what is left.
            refresh_near_duplicates(batch.out)
    return result
