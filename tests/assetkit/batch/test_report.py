"""The page of a batch: a row and details for every item, and no name of a file is ever markup or script."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

import pytest

from assetkit.batch.finished_items import FinishedItems
from assetkit.batch.report import DETAILS, ITEMS_PER_FILE, PAGE, write_report
from assetkit.batch.report_file import FinishedBatch
from schemas.diagnostics import finding
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

HOSTILE = [
    '</script><img src=x onerror="alert(1)">',
    "<!--",
    "a\u2028b\nc",
    "${alert(1)}",
    "\x1b[31mred",
    "O'Brien \\u003c",
]


class Tags(HTMLParser):
    """Collects the tags of a page and the text of its scripts."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.scripts: list[str] = []
        self._in_script = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag == "script":
            self._in_script = True
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._in_script = self._in_script and tag != "script"

    def handle_data(self, data: str) -> None:
        if self._in_script:
            self.scripts[-1] += data


def written(out: Path, sources: list[str]) -> tuple[list[list[object]], list[str], Tags]:
    """Rows of the list and details of all items, as a browser would read them, and the tags of the page."""
    refused = finding("asset/truncated", "it ends early: " + sources[0])
    with FinishedItems(out / "work", len(sources)) as finished:
        for number, source in enumerate(sources):
            item = ReportItem(
                source=source, outcome=ItemOutcome.REJECTED, codes=(refused.code,), diagnostics=(refused,)
            )
            finished.add(number, item)
        write_report(FinishedBatch(out, finished.totals(1.0), finished.reasons()), finished)
    page = Tags()
    page.feed((out / PAGE).read_text(encoding="utf-8"))
    (script,) = page.scripts
    listed = script[script.index("const rows = [") : script.index("const perFile")].partition("[")[2].rpartition("]")[0]
    rows = json.loads(f"[{listed.rstrip().rstrip(',')}]")
    details = [
        text
        for number, file in enumerate(sorted((out / DETAILS).iterdir()))
        for text in json.loads(file.read_text(encoding="utf-8").removeprefix(f"details({number}, ")[: -len(");\n")])
    ]
    return rows, details, page


@pytest.mark.parametrize("count", [1, ITEMS_PER_FILE, 2 * ITEMS_PER_FILE + 1])
def test_every_item_has_a_row_and_its_details_in_order(count: int, tmp_path: Path):
    sources = [f"part_{number}.obj" for number in range(count)]
    rows, details, _ = written(tmp_path, sources)
    assert [row[0] for row in rows] == sources
    assert len(details) == count
    assert all(source in text for source, text in zip(sources, details, strict=True))


def test_names_of_files_are_text_and_nothing_else(tmp_path: Path):
    (tmp_path / "plain").mkdir()
    (tmp_path / "hostile").mkdir()
    _, _, plain = written(tmp_path / "plain", ["a"] * len(HOSTILE))
    rows, details, hostile = written(tmp_path / "hostile", HOSTILE)
    assert hostile.tags == plain.tags
    assert [row[0] for row in rows] == HOSTILE
    for text in details:
        shown = Tags()
        shown.feed(text)
        assert set(shown.tags) <= {"h2", "p", "span", "ul", "li", "code"}


def test_details_of_an_earlier_batch_do_not_stay(tmp_path: Path):
    written(tmp_path, ["a"] * (ITEMS_PER_FILE + 1))
    written(tmp_path, ["b"])
    assert [file.name for file in (tmp_path / DETAILS).iterdir()] == ["00000.js"]
