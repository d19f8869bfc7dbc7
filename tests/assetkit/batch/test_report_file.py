"""Items of a batch live on disk: the report that is written from there holds what each item said, in order."""

from __future__ import annotations

import json
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given

from assetkit.batch.finished_items import FinishedItems
from assetkit.batch.report_file import REPORT, FinishedBatch, read_items, read_report, write_report_json
from schemas.diagnostics import InvalidInput, Severity, finding
from schemas.outcome import EndpointUse, ItemOutcome
from schemas.report import IngestReport, ReportItem

CODES = ("asset/truncated", "asset/small-holes", "asset/no-grasp")
NAMES = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12)


@st.composite
def item(draw: st.DrawFn) -> ReportItem:
    codes = draw(st.lists(st.sampled_from(CODES), max_size=4))
    findings = tuple(finding(code, draw(NAMES), severity=draw(st.sampled_from(list(Severity)))) for code in codes)
    return ReportItem(
        source=draw(NAMES),
        outcome=draw(st.sampled_from(list(ItemOutcome))),
        codes=tuple(codes),
        diagnostics=findings,
        packages=tuple(draw(st.lists(NAMES, max_size=2))),
        cached=draw(st.sampled_from([(), ("item",)])),
        endpoint=draw(st.none() | st.builds(EndpointUse, requests=st.integers(0, 9))),
        seconds={"cell": draw(st.floats(0.0, 9.0))},
    )


def told_of(one: ReportItem) -> set[str]:
    """Codes of warnings and errors."""
    return {d.code for d in one.diagnostics if d.severity is not Severity.INFO}


@given(st.lists(item(), max_size=12), st.randoms(use_true_random=False), st.data())
def test_a_report_says_what_the_items_said_whenever_they_finished(
    tmp_path_factory: pytest.TempPathFactory, items: list[ReportItem], random, data: st.DataObject
):
    out = tmp_path_factory.mktemp("out")
    order = [n for n in range(len(items)) if data.draw(st.booleans(), label="finished")]
    random.shuffle(order)
    with FinishedItems(out / "work", len(items)) as finished:
        for number in order:
            finished.add(number, items[number])
        batch = FinishedBatch(out, finished.totals(1.5), finished.reasons(), interrupted=len(order) < len(items))
        write_report_json(batch, finished.lines())
    assert not list((out / "work").iterdir())
    done = [items[number] for number in sorted(order)]
    report = IngestReport.model_validate(json.loads((out / REPORT).read_text()))
    assert list(report.items) == done == list(read_items(out)) == list(batch.items)
    assert report == read_report(out)
    assert report.interrupted == (len(done) < len(items))
    assert report.totals["items"] == len(done)
    for outcome in ItemOutcome:
        assert report.totals[outcome.value] == sum(i.outcome is outcome for i in done)
    assert report.totals["packages"] == sum(len(i.packages) for i in done)
    assert report.totals["cached"] == sum(bool(i.cached) for i in done)
    asked = [i.endpoint.requests for i in done if i.endpoint is not None and not i.cached]
    assert report.totals.get("endpoint_requests", 0) == sum(asked)
    for reason in report.reasons:
        having = [
            i for i in done if any(d.code == reason.code and d.severity is not Severity.INFO for d in i.diagnostics)
        ]
        assert reason.items == len(having) > 0
        assert reason.example == having[0].source
        assert reason.outcomes == {o: n for o in ItemOutcome if (n := sum(i.outcome is o for i in having))}
    assert {reason.code for reason in report.reasons} == {code for i in done for code in told_of(i)}


def test_what_rejects_most_comes_first(tmp_path: Path):
    def with_code(code: str, outcome: ItemOutcome) -> ReportItem:
        diagnostic = finding(code, "so", severity=Severity.ERROR)
        return ReportItem(source="a", outcome=outcome, codes=(code,), diagnostics=(diagnostic,))

    said = [(CODES[0], ItemOutcome.REVIEW)] * 5 + [(CODES[1], ItemOutcome.REJECTED), (CODES[2], ItemOutcome.REPAIRED)]
    with FinishedItems(tmp_path, len(said)) as finished:
        for number, each in enumerate(said):
            finished.add(number, with_code(*each))
        assert [reason.code for reason in finished.reasons()] == [CODES[1], CODES[0], CODES[2]]


def test_a_report_of_an_earlier_layout_is_read_and_a_damaged_one_named(tmp_path: Path):
    report = IngestReport(items=(ReportItem(source="a", outcome=ItemOutcome.ACCEPTED),), totals={})
    (tmp_path / REPORT).write_text(report.model_dump_json(indent=1))
    assert list(read_items(tmp_path)) == list(report.items)
    write_report_json(FinishedBatch(tmp_path, {}), [i.model_dump_json().encode() for i in report.items])
    whole = (tmp_path / REPORT).read_bytes()
    for cut in (whole[:-200], whole[: whole.index(b"\n") + 9], b"{"):
        (tmp_path / REPORT).write_bytes(cut)
        with pytest.raises(InvalidInput) as refused:
            list(read_items(tmp_path))
        assert refused.value.diagnostic.code == "asset/report-unreadable"
    (tmp_path / REPORT).unlink()
    with pytest.raises(FileNotFoundError):
        list(read_items(tmp_path))
