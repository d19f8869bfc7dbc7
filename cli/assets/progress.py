"""The progress of an ingest: a bar with a tally of outcomes, or, where no one watches a terminal, lines on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from rich.progress import TextColumn

from assetkit.batch.run_batch import Progress
from cli import text
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

LINE_S = 30.0  # between two lines of a log: a night over 10,000 files gives some hundred


@contextmanager
def shown_progress(*, quiet: bool) -> Iterator[Progress]:
    """The progress, which the batch calls as items finish; it appears at the first call."""
    if not (quiet or text.console.is_terminal):
        yield logged_progress(lambda line: print(line, file=sys.stderr, flush=True), time.monotonic)
        return
    bar = text.progress(TextColumn("{task.fields[tally]}"), quiet=quiet)
    task = bar.add_task("ingest", total=None, tally="")
    tally = dict.fromkeys(ItemOutcome, 0)
    with ExitStack() as shown:

        def show(done: int, total: int, item: ReportItem | None) -> None:
            if item is None:
                shown.enter_context(bar)
            else:
                tally[item.outcome] += 1
            outcomes = " ".join(f"[{text.STYLE[o]}]{n} {o.value}[/]" for o, n in tally.items() if n)
            bar.update(task, total=total, completed=done, tally=outcomes)

        yield show


def logged_progress(write: Callable[[str], object], clock: Callable[[], float]) -> Progress:
    """Writes a line with the tally of outcomes at most every `LINE_S` seconds of `clock`."""
    tally = dict.fromkeys(ItemOutcome, 0)
    last_s = clock()

    def show(done: int, total: int, item: ReportItem | None) -> None:
        nonlocal last_s
        if item is not None:
            tally[item.outcome] += 1
        if clock() - last_s >= LINE_S:
            last_s = clock()
            outcomes = ", ".join(f"{n} {outcome.value}" for outcome, n in tally.items() if n)
            write(f"mana: {done} of {total} items done: {outcomes}")

    return show
