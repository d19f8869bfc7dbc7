"""The page of a batch in a real Chromium: hostile names stay text, and ten thousand items load and filter at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from assetkit.batch.finished_items import FinishedItems
from assetkit.batch.report import PAGE, write_report
from assetkit.batch.report_file import FinishedBatch
from schemas.diagnostics import finding
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem
from tests.acceptance.browser import answer_of_page

HOSTILE = [
    '</script><img src=x onerror="alert(1)">.obj',
    "<svg onload=alert(2)>.glb",
    "<!--.stl",
    "${alert(3)}.ply",
    "';alert(4);'.obj",
    "a\u2028alert(5).obj",
    '"><iframe srcdoc="<script>parent.alert(6)</script>">.obj',
    "\x1b[31mred\x07.obj",
    "javascript:alert(7)",
    "O'Brien \\u003cscript\\u003e.dae",
]
EACH_ITEM = """
const wait = ms => new Promise(done => setTimeout(done, ms)), seen = [];
for (let n = 0; n < rows.length; n++) {
  choose(n);
  for (let k = 0; k < 100 && !panel.querySelector("h2"); k++) await wait(50);
  seen.push({ heading: panel.querySelector("h2").textContent,
    elements: [...new Set([...panel.querySelectorAll("*")].map(e => e.tagName))],
    handlers: [...document.querySelectorAll("*")]
      .filter(e => e.getAttributeNames().some(a => a.startsWith("on"))).length,
    scripts: panel.querySelectorAll("script, img, svg, iframe").length });
}
return { seen, hijacked, listed: [...list.querySelectorAll(".row small:first-of-type")].map(e => e.textContent) };
"""
FILTER = """
const began = performance.now();
words.value = "part_12"; filter();
const found = shown.textContent, some = list.querySelectorAll(".row").length;
code.value = "asset/truncated"; words.value = ""; filter();
const both = visible.length;
list.scrollTop = 1e9; draw();
return { found, some, both, drawn: list.querySelectorAll(".row").length,
  last: [...list.querySelectorAll(".row small:first-of-type")].map(e => e.textContent).includes("part_9999.obj") };
"""


def page_of(out: Path, sources: list[str]) -> Path:
    """The report of a batch that refused every source, each second one as truncated."""
    codes = ("asset/truncated", "asset/source-missing")
    with FinishedItems(out / "work", len(sources)) as finished:
        for number, source in enumerate(sources):
            refused = finding(codes[number % 2], f"this is wrong with {source}")
            finished.add(
                number,
                ReportItem(source=source, outcome=ItemOutcome.REJECTED, codes=(refused.code,), diagnostics=(refused,)),
            )
        write_report(FinishedBatch(out, finished.totals(1.0), finished.reasons()), finished)
    return out / PAGE


def test_hostile_names_are_text_in_a_browser(tmp_path: Path) -> None:
    answer: dict[str, Any] = answer_of_page(page_of(tmp_path, HOSTILE), EACH_ITEM)
    assert answer["hijacked"] == []
    assert len(answer["seen"]) == len(HOSTILE)
    for name, seen in zip(HOSTILE, answer["seen"], strict=True):
        assert seen["handlers"] == seen["scripts"] == 0
        assert set(seen["elements"]) <= {"H2", "P", "SPAN", "UL", "LI", "CODE"}
        visible = "".join(c for c in name if c.isprintable())
        assert "".join(c for c in seen["heading"] if c.isprintable()).strip().startswith(visible)
    assert set(answer["listed"]) == set(HOSTILE)


def test_ten_thousand_items_are_filtered_and_only_what_is_in_view_is_drawn(tmp_path: Path) -> None:
    answer = answer_of_page(page_of(tmp_path, [f"part_{n}.obj" for n in range(10_000)]), FILTER)
    assert answer["found"] == "111 of 10000"
    assert answer["both"] == 5_000
    assert 0 < answer["some"] < 40
    assert 0 < answer["drawn"] < 40
    assert not answer["last"], "part_9999 is of the other code"
