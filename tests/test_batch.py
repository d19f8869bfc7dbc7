"""The batch keeps its promises whatever its workers do. Workers here are one-line scripts, so this is fast."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from assetkit.discover import discover
from assetkit.ingest import Batch, collect, ingest
from assetkit.journal import Entry, Journal
from assetkit.options import Options
from assetkit.pipeline import process_source
from assetkit.report import build_report, write_report
from jobs.cell import Limits
from schemas.diagnostics import finding
from schemas.outcome import ItemOutcome, Repair
from schemas.report import IngestReport, ReportItem
from sim.fake import FakeSimulator

GOOD = """
import json, sys
from pathlib import Path
from assetkit import memory
from assetkit.ingest import candidate_of
from schemas.report import ReportItem
request = json.loads(Path(sys.argv[1]).read_text())
candidate = candidate_of(request)
text = candidate.file.path.read_text()
count = Path(request['out']) / f'{candidate.asset_id}.runs'
count.write_text(str(int(count.read_text()) + 1) if count.exists() else '1')
if 'abort' in text: import os; os.abort()
if 'hang' in text: import time; time.sleep(60)
if 'memory' in text: x = bytearray(8 * 2**30)
if 'exit' in text: raise SystemExit('gave up')
item = ReportItem(source=candidate.given, outcome='accepted', seconds={'intake': 0.1})
memory.remember(Path(request['note']), memory.stored_from(item, candidate, Path(request['out'])))
"""


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a", "b", "c"):
        (folder / f"{name}.obj").write_text("good")
    return folder


def batch(out: Path, **changes) -> Batch:
    worker = (sys.executable, "-c", GOOD)
    return Batch(out=out, options=Options(), worker=worker, limits=Limits(5.0, 4096), **changes)


def run(folder: Path, this: Batch) -> dict[str, ReportItem]:
    return {Path(i.source).stem: i for i in ingest(discover([folder]), this)}


def runs(out: Path) -> dict[str, int]:
    return {p.stem: int(p.read_text()) for p in out.glob("*.runs")}


def test_crashes_hangs_and_failures_cost_only_their_own_item(sources: Path, tmp_path: Path):
    (sources / "crash.obj").write_text("abort")
    (sources / "hang.obj").write_text("hang")
    (sources / "fail.obj").write_text("exit")
    (sources / "greedy.obj").write_text("memory")
    items = run(sources, batch(tmp_path / "out", jobs=2))
    assert {n: i.outcome for n, i in items.items() if len(n) == 1} == dict.fromkeys("abc", ItemOutcome.ACCEPTED)
    assert items["crash"].codes == ("asset/worker-crashed",)
    assert items["hang"].codes == ("asset/worker-timeout",)
    assert items["hang"].diagnostics[0].bound == 5.0
    assert items["fail"].codes == ("asset/worker-crashed",)
    assert items["greedy"].codes == ("asset/worker-out-of-memory",)
    assert "gave up" in items["fail"].diagnostics[0].headline
    assert not list((tmp_path / "out" / ".work").glob("*"))


def test_an_unchanged_source_is_not_made_again_and_a_changed_one_is(sources: Path, tmp_path: Path):
    this = batch(tmp_path / "out")
    run(sources, this)
    (sources / "b.obj").write_text("good, but different")
    items = run(sources, this)
    assert {n: i.cached for n, i in items.items()} == {"a": ("item",), "b": (), "c": ("item",)}
    assert runs(this.out) == {"a": 1, "b": 2, "c": 1}


def test_other_options_are_another_result(sources: Path, tmp_path: Path):
    run(sources, batch(tmp_path / "out"))
    other = Batch(tmp_path / "out", Options(units="mm"), (sys.executable, "-c", GOOD))
    assert all(i.cached == () for i in run(sources, other).values())


def test_crashed_items_are_tried_again_unless_resumed(sources: Path, tmp_path: Path):
    (sources / "crash.obj").write_text("abort")
    run(sources, batch(tmp_path / "out"))
    run(sources, batch(tmp_path / "out", resume=True))
    assert runs(tmp_path / "out")["crash"] == 1
    run(sources, batch(tmp_path / "out"))
    assert runs(tmp_path / "out")["crash"] == 2


def test_interrupted_batch_keeps_what_was_finished(sources: Path, tmp_path: Path):
    this = batch(tmp_path / "out")
    candidates = discover([sources])
    started = ingest(candidates, this)
    next(started)
    started.close()
    finished = list(collect(candidates, this))
    assert 1 <= len(finished) < 3
    report = build_report(finished, wall_seconds=1.0, interrupted=True)
    write_report(report, this.out)
    loaded = IngestReport.model_validate_json((this.out / "report.json").read_bytes())
    assert loaded.interrupted
    assert loaded.totals["items"] == len(finished)
    assert len(run(sources, this)) == 3


def test_report_rows_follow_the_sources_whatever_the_order_of_finishing(sources: Path, tmp_path: Path):
    this = batch(tmp_path / "out", jobs=2)
    run(sources, this)
    assert [Path(i.source).stem for i in collect(discover([sources]), this)] == ["a", "b", "c"]


def test_a_bug_in_a_stage_is_reported_as_such(sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (sources / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")

    def broken(*_: object) -> None:
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr("assetkit.pipeline.run_stages", broken)
    item = process_source(
        discover([sources / "a.obj"])[0],
        options=Options(),
        simulator=FakeSimulator(),
        out=tmp_path / "out",
        work_dir=tmp_path / "work",
    )
    assert item.outcome is ItemOutcome.REJECTED
    assert item.codes == ("asset/internal-error",)
    assert "ZeroDivisionError: a defect" in item.traceback


def test_outcome_of_a_journal():
    assert Journal().outcome is ItemOutcome.ACCEPTED
    repair = Repair(name="hole_fill", code="asset/small-holes", stage="canonicalize")
    assert Journal({"a": Entry(repairs=(repair,))}).outcome is ItemOutcome.REPAIRED
    assert Journal({"a": Entry(repairs=(repair,)), "b": Entry(review=True)}).outcome is ItemOutcome.REVIEW
    refused = finding("asset/path-escape", "out")
    assert Journal({"a": Entry((refused,), review=True)}).outcome is ItemOutcome.REJECTED


def test_report_json_has_the_stable_keys(sources: Path, tmp_path: Path):
    this = batch(tmp_path / "out")
    run(sources, this)
    write_report(build_report(collect(discover([sources]), this), wall_seconds=2.0, interrupted=False), this.out)
    report = json.loads((this.out / "report.json").read_text())
    assert report["schema_version"]
    assert set(report["items"][0]) >= {"source", "outcome", "codes", "packages", "repairs", "seconds"}
    assert report["totals"]["accepted"] == 3
    assert report["items"][0]["source"] == str(sources / "a.obj")
