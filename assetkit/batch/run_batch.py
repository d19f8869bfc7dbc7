"""A batch from sources to a library: discovery, the lock of the folder, one item per source, report and catalogue."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from assetkit.batch.item_cells import DEFAULT_LIMITS, Batch, default_jobs, run_items
from assetkit.batch.report import build_report, write_report
from assetkit.library import catalog
from assetkit.options import Options
from assetkit.sources.discover import SourceAsset, discover
from jobs.cell import Limits
from jobs.lock import exclusive
from jobs.placement import Placement
from schemas.report import IngestReport, ReportItem

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
    progress: Progress | None = None,
) -> IngestReport:
    """Turn source files (or folders of them) into packages in the folder `out`, and return the report of the batch.

    `engine` names the simulator that tries each package, as `"module:attribute"`; PyBullet is
    `"sim.bullet.simulator:BulletSimulator"`. `options` hold what the caller knows of the sources: units, up axis, role,
    category, licence. `root` is the folder that references may not leave. Cells run at `placement`, by default one per
    core of this machine, each under `limits`. Unchanged sources are taken from the store; `resume` also keeps items
    that crashed or timed out, `fresh` makes all anew. `out` holds packages, `report.json`, `report.html` and
    `catalog.sqlite` afterwards, also after Ctrl-C (`interrupted` in the report).

    Raises FolderInUse while another process writes into `out`, FolderUnusable where nothing can be written,
    ClusterUnusable where no worker can be used, and InvalidInput when the file of people's decisions in `out` cannot
    be read.
    """
    out = Path(out)
    with exclusive(out):
        candidates = discover([Path(source) for source in sources], root=None if root is None else Path(root), out=out)
        batch = Batch(
            out=out,
            options=options or Options(),
            engine=engine,
            placement=placement or Placement(default_jobs()),
            limits=limits,
            resume=resume,
            fresh=fresh,
        )
        return run_batch(candidates, batch, progress)


def run_batch(candidates: Sequence[SourceAsset], batch: Batch, progress: Progress | None = None) -> IngestReport:
    """Run all items, then write report and catalogue, also after Ctrl-C. The caller holds the lock of the folder."""
    started = time.monotonic()
    interrupted = False
    finished: dict[str, ReportItem] = {}
    report_progress = progress or (lambda done, total, item: None)
    report_progress(0, len(candidates), None)
    try:
        for item in run_items(candidates, batch):
            finished[item.source] = item
            report_progress(len(finished), len(candidates), item)
    except KeyboardInterrupt:
        interrupted = True
    items = [finished[c.given] for c in candidates if c.given in finished]
    report = build_report(items, wall_seconds=time.monotonic() - started, interrupted=interrupted)
    write_report(report, batch.out)
    catalog.rebuild(batch.out)
    return report
