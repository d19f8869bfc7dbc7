"""`mana gap find` for several measurement folders: a table of verdicts, and a report in a folder for each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import typer
from rich.markup import escape

from cli import text
from cli.engines import REPLAY_ENGINE
from jobs.placement import Placement
from simgap.find_many import FoundIn, find_many


def find_in_all(measurements: Sequence[Path], out: Path, placement: Placement, *, quick: bool, as_json: bool) -> None:
    """Search all folders and print the verdicts in their order. Exits with 1 when one was refused, 2 after Ctrl-C."""
    answers: dict[Path, FoundIn] = {}
    interrupted = False
    with text.progress(quiet=as_json) as bar:
        task = bar.add_task("searching", total=len(measurements))
        try:
            for one in find_many(measurements, out, engine=REPLAY_ENGINE, placement=placement, quick=quick):
                answers[one.measurement] = one
                bar.update(task, completed=len(answers))
        except KeyboardInterrupt:
            interrupted = True
    listed = [answers[measurement] for measurement in measurements if measurement in answers]
    if as_json:
        print(json.dumps([_row(one) for one in listed], indent=1))
    else:
        rows: list[dict[str, object]] = [
            {"measurement": one.measurement.name, "answer": _statement(one)} for one in listed
        ]
        text.show_rows(rows, {"measurement": "measurement", "answer": "answer"})
        text.console.print(f"reports: {escape(str(out / '*' / 'report.html'))}", soft_wrap=True)
        if interrupted:
            text.console.print(f"interrupted after {len(listed)} folders; the same command continues")
    if interrupted:
        raise typer.Exit(2)
    raise typer.Exit(1 if any(one.refused is not None for one in listed) else 0)


def _statement(one: FoundIn) -> str:
    if one.refused is not None:
        return f"refused, {one.refused.code}: {one.refused.headline}"
    return one.verdict.statement if one.verdict is not None else ""


def _row(one: FoundIn) -> dict[str, object]:
    return {
        "measurement": str(one.measurement),
        "out": str(one.out),
        "verdict": None if one.verdict is None else one.verdict.model_dump(mode="json"),
        "refused": None if one.refused is None else one.refused.model_dump(mode="json"),
    }
