"""`report.json` with one item per line: written and read without ever holding all items in memory."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from schemas.diagnostics import InvalidInput, Location, finding
from schemas.report import CodeCount, IngestReport, ReportItem

REPORT = "report.json"
_ITEMS = b'"items":[\n'  # ends the first line; each item then fills a line, until one that begins with "]"


@dataclass(frozen=True)
class FinishedBatch:
    """A batch that has ended, with its figures; `items` reads its report anew each time, one item after another."""

    out: Path
    totals: dict[str, float]
    reasons: tuple[CodeCount, ...] = ()
    interrupted: bool = False

    @property
    def items(self) -> Iterator[ReportItem]:
        """The items in the order of the sources."""
        return read_items(self.out)


def write_report_json(batch: FinishedBatch, items: Iterable[bytes]) -> None:
    """Write `report.json` of a batch, whose `items` are given as JSON; a reader sees the old file or all of the new."""
    temporary = batch.out / f".{REPORT}"
    reasons = [reason.model_dump(mode="json") for reason in batch.reasons]
    version = IngestReport.model_fields["schema_version"].default
    with temporary.open("wb") as file:
        file.write(b'{"schema_version":' + _json(version) + b"," + _ITEMS)
        for number, item in enumerate(items):
            file.write((b",\n" if number else b"") + item)
        file.write(b'\n],"reasons":' + _json(reasons) + b',\n"totals":' + _json(batch.totals))
        file.write(b',"interrupted":' + _json(batch.interrupted) + b"}\n")
    temporary.replace(batch.out / REPORT)


def read_items(out: Path) -> Iterator[ReportItem]:
    """The items of the last run into `out`. Raises as `read_report`."""
    with (out / REPORT).open("rb") as file:
        try:
            if not file.readline().endswith(_ITEMS):  # of an earlier version, or edited
                yield from read_report(out).items
                return
            for line in file:
                if line.startswith(b"]"):
                    return
                if text := line.strip().removesuffix(b","):
                    yield ReportItem.model_validate_json(text)
        except ValidationError as error:
            raise _unreadable() from error
    raise _unreadable()


def read_report(out: Path) -> IngestReport:
    """The whole report of the last run.

    Raises FileNotFoundError when there is none, InvalidInput (`asset/report-unreadable`) when it is damaged.
    """
    try:
        return IngestReport.model_validate_json((out / REPORT).read_bytes())
    except ValidationError as error:
        raise _unreadable() from error


def _unreadable() -> InvalidInput:
    headline = f"{REPORT} cannot be read; `mana assets ingest` writes it anew"
    return InvalidInput(finding("asset/report-unreadable", headline, where=Location(file=REPORT)))


def _json(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass")
