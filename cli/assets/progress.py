"""The progress bar of an ingest: how many items are done, and a tally of their outcomes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from rich.progress import TextColumn

from assetkit.batch.run_batch import Progress
from cli import text
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem


@contextmanager
def shown_progress(*, quiet: bool) -> Iterator[Progress]:
    """A progress bar with a tally of outcomes, which the batch calls as items finish; it appears at the first call."""
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
