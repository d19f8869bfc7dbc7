"""`mana assets ingest --watch`: a line for each item as it is finished, until Ctrl-C."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import typer
from rich.markup import escape

from assetkit.batch.report_file import FinishedBatch
from assetkit.batch.watch import watch
from cli import text
from jobs.lock import FolderInUse
from schemas.report import ReportItem


def watch_sources(
    sources: Sequence[Path], out: Path, run: Callable[..., FinishedBatch], settle_s: float, *, as_json: bool
) -> None:
    """Watch `sources` and run passes of an ingest, `run`, until Ctrl-C. Raises typer.Exit with code 2 where that cut a
    pass short, and FileNotFoundError for a source that is not there at the start.
    """
    if not settle_s > 0.0:
        raise typer.BadParameter("must be above zero", param_hint="--settle")
    for source in sources:
        if not source.exists():
            raise FileNotFoundError(source)

    def say(line: str) -> None:
        if not as_json:
            text.console.print(line, soft_wrap=True)

    def show(_done: int, _total: int, item: ReportItem | None) -> None:
        if item is None or item.cached == ("item",):
            return
        if as_json:
            print(item.model_dump_json(), flush=True)
            return
        codes = f" ({', '.join(item.codes)})" if not item.packages else ""
        packages = f" -> {', '.join(item.packages)}" if item.packages else ""
        style = text.STYLE[item.outcome]
        say(f"[{style}]{item.outcome.value}[/{style}] {escape(item.source + packages + codes)}")

    def waits(reason: FolderInUse | None) -> None:
        say(f"{escape(str(reason))}: the next pass waits" if reason else "waiting for files; Ctrl-C ends")

    say(f"watching {escape(', '.join(map(str, sources)))}; Ctrl-C ends")
    last = watch(
        sources, out, lambda selection: run(selection=selection, progress=show), settle_s=settle_s, waits=waits
    )
    if last is not None:
        say(f"report: {escape(str(out / 'report.html'))}")
    if last is not None and last.interrupted:
        say("the last pass was interrupted; the same command continues")
        raise typer.Exit(2)
