"""Takes up the files of a folder as they come: passes of an ingest over what has settled, until somebody ends it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from assetkit.batch.arrivals import Arrivals, PassScope, files_below
from assetkit.batch.report_file import FinishedBatch
from jobs.lock import FolderInUse

SETTLE_S = 2.0  # longer than pauses of a copy over a network; a person who drops a file still sees it taken up at once
LOOK_S = 0.5  # rest between two looks, at least
RESTS_PER_LOOK = 9.0  # rests are that many times as long as looks: at most a tenth of a core goes into them


def watch(
    sources: Sequence[Path],
    out: Path,
    run_pass: Callable[[PassScope], FinishedBatch],
    *,
    settle_s: float = SETTLE_S,
    look_s: float = LOOK_S,
    waits: Callable[[FolderInUse | None], object] = lambda reason: None,
) -> FinishedBatch | None:
    """Call `run_pass` whenever files have settled, until Ctrl-C; the last pass, None when there was none.

    A pass that Ctrl-C cut short is the last one and `interrupted`. `waits` is called before each rest that follows a
    pass, with the reason when another process writes into `out`: the pass is then tried again. Raises what `run_pass`
    raises otherwise.
    """
    arrivals = Arrivals(settle_s)
    last: FinishedBatch | None = None
    rested = False
    try:
        while True:
            began_s = time.monotonic()
            arrivals.look(files_below(sources, out), began_s)
            rest_s = max(look_s, RESTS_PER_LOOK * (time.monotonic() - began_s))
            selection = arrivals.next_pass(last)
            if selection is not None and all(source.exists() for source in sources):
                try:
                    last = run_pass(selection)
                except FolderInUse as in_use:
                    if not rested:
                        waits(in_use)
                    rested = True
                else:
                    if last.interrupted:
                        return last
                    arrivals.taken(selection)
                    waits(None)
                    rested = False
            time.sleep(rest_s)
    except KeyboardInterrupt:
        return last
