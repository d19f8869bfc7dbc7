"""The batch keeps its promises whatever its workers do. Workers here are one-line scripts, so this is fast."""

from __future__ import annotations

import errno
import json
import os
import shutil
import sys
from collections.abc import Generator
from pathlib import Path
from typing import cast

import pytest

from assetkit.acceptance import judge_package
from assetkit.batch import item_cells, ownership, result_store, worker
from assetkit.batch.item_cells import Batch, run_items
from assetkit.batch.run_batch import run_batch
from assetkit.options import Options
from assetkit.package import release
from assetkit.pipeline import process_source
from assetkit.sources.discover import discover
from assetkit.stage import Appearance, Draft, Tools
from assetkit.stages.appearance import NormalizeAppearance
from cli.engines import SIMULATOR
from gate.static_gate import gate
from jobs.cell import CellResult, Limits
from jobs.placement import Placement
from schemas.diagnostics import Diagnostic
from schemas.outcome import ItemOutcome, Outcome
from schemas.report import ReportItem
from sim.fake import FakeSimulator

GOOD = """
import json, sys
from collections.abc import Generator
from pathlib import Path
from typing import cast
from assetkit.batch import result_store
from assetkit.batch.item_cells import candidate_of
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
full = Path(request['out']) / 'full'
if 'storage' in text and count.read_text() == '1': full.touch()
if full.exists() and 'storage' in text: raise OSError(28, 'No space left on device')
item = ReportItem(source=candidate.given, outcome='accepted', seconds={'intake': 0.1})
if 'verdict' in text: item = ReportItem(source=candidate.given, outcome='rejected', codes=(text.split()[1],))
if 'grows' in text: candidate.file.path.write_text('good')
result_store.write_stored(Path(request["note"]), result_store.stored_from(item, candidate, Path(request['out'])))
"""


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a", "b", "c"):
        (folder / f"{name}.obj").write_text("good")
    return folder


RECORD_SAMPLE = Path(__file__).parents[1] / "data" / "record.json"


def batch(out: Path, **changes) -> Batch:
    worker = (sys.executable, "-c", GOOD)
    return Batch(
        out=out, options=Options(), engine="sim.fake:FakeSimulator", worker=worker, limits=Limits(5.0, 4096), **changes
    )


def run(folder: Path, this: Batch) -> dict[str, ReportItem]:
    return {Path(i.source).stem: i for i in run_items(discover([folder]), this)}


def runs(out: Path) -> dict[str, int]:
    return {p.stem: int(p.read_text()) for p in out.glob("*.runs")}


def test_crashes_hangs_and_failures_cost_only_their_own_item(sources: Path, tmp_path: Path):
    (sources / "crash.obj").write_text("abort")
    (sources / "hang.obj").write_text("hang")
    (sources / "fail.obj").write_text("exit")
    (sources / "greedy.obj").write_text("memory")
    items = run(sources, batch(tmp_path / "out", placement=Placement(2)))
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
    other = Batch(tmp_path / "out", Options(units="mm"), SIMULATOR, (sys.executable, "-c", GOOD))
    assert all(i.cached == () for i in run(sources, other).values())


def test_crashed_items_are_tried_again_unless_resumed(sources: Path, tmp_path: Path):
    (sources / "crash.obj").write_text("abort")
    run(sources, batch(tmp_path / "out"))
    run(sources, batch(tmp_path / "out", resume=True))
    assert runs(tmp_path / "out")["crash"] == 1
    run(sources, batch(tmp_path / "out"))
    assert runs(tmp_path / "out")["crash"] == 2


def test_an_error_of_the_storage_is_not_stored(sources: Path, tmp_path: Path):
    """The worker of `a` ends with an OSError, as where the disk is full: the next run makes it, resumed or not."""
    (sources / "a.obj").write_text("storage")
    items = run(sources, batch(tmp_path / "out"))
    assert items["a"].outcome is ItemOutcome.REJECTED
    assert items["a"].codes == ("asset/storage-failed",)
    assert "No space left" in items["a"].diagnostics[0].headline
    assert {items[n].outcome for n in "bc"} == {ItemOutcome.ACCEPTED}
    (tmp_path / "out" / "full").unlink()
    again = run(sources, batch(tmp_path / "out", resume=True))
    assert {n: i.cached for n, i in again.items()} == {"a": (), "b": ("item",), "c": ("item",)}
    assert again["a"].outcome is ItemOutcome.ACCEPTED


def test_an_unwritable_store_is_no_verdict_on_the_source(
    sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Errors of this process: the note of `a` cannot be written once."""
    this, written = batch(tmp_path / "out"), result_store.write_stored

    def full(note: Path, stored: result_store.StoredResult) -> None:
        if Path(stored.item.source).stem == "a":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written(note, stored)

    monkeypatch.setattr(result_store, "write_stored", full)
    assert run(sources, this)["a"].codes == ("asset/storage-failed",)
    monkeypatch.setattr(result_store, "write_stored", written)
    again = run(sources, batch(tmp_path / "out", resume=True))
    assert {n: (i.outcome, i.cached) for n, i in again.items()} == {
        "a": (ItemOutcome.ACCEPTED, ()),
        "b": (ItemOutcome.ACCEPTED, ("item",)),
        "c": (ItemOutcome.ACCEPTED, ("item",)),
    }


@pytest.mark.parametrize(
    "code", ["asset/storage-failed", "asset/internal-error", "asset/output-occupied", "asset/source-missing"]
)
def test_verdicts_that_do_not_follow_from_the_source_are_never_stored(code: str, sources: Path, tmp_path: Path):
    (sources / "a.obj").write_text(f"verdict {code}")
    this = batch(tmp_path / "out", resume=True)
    assert run(sources, this)["a"].codes == (code,)
    assert run(sources, this)["a"].cached == ()
    assert runs(this.out) == {"a": 2, "b": 1, "c": 1}


def test_a_source_written_to_while_it_is_read_is_read_again(sources: Path, tmp_path: Path):
    """Half a file may have been read, whatever its hash is now."""
    (sources / "a.obj").write_text("grows")
    run(sources, batch(tmp_path / "out"))
    assert (sources / "a.obj").read_text() == "good"
    assert run(sources, batch(tmp_path / "out"))["a"].cached == ()
    assert run(sources, batch(tmp_path / "out"))["a"].cached == ("item",)


def test_packages_survive_an_error_of_the_storage(tmp_path: Path):
    (tmp_path / "mug.obj").write_text("mug")
    [mug] = discover([tmp_path / "mug.obj"])
    release.publish(package(tmp_path, "mug"), tmp_path / "mug")
    ownership.record_ownership(mug, ["mug"], tmp_path)
    ownership.record_ownership(mug, [], tmp_path, complete=False)
    assert (tmp_path / "mug").exists()
    ownership.record_ownership(mug, [], tmp_path)
    assert not (tmp_path / "mug").exists()


def test_a_lost_machine_is_no_verdict_and_takes_no_package_along(
    sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """A worker of a cluster may die several times in a row; the source is made by the next run."""
    this = batch(tmp_path / "out", resume=True)
    [one] = [candidate for candidate in discover([sources]) if candidate.asset_id == "a"]
    release.publish(package(this.out, "a"), this.out / "a")
    ownership.record_ownership(one, ["a"], this.out)
    with monkeypatch.context() as lost:
        ended = CellResult("lost", 0, "the workers that ran it died", 0.0)
        lost.setattr(item_cells, "run_cell", lambda *_, **__: ended)
        assert run(sources, this)["a"].codes == ("asset/worker-crashed",)
    assert (this.out / "a").is_dir()
    assert run(sources, this)["a"].outcome is ItemOutcome.ACCEPTED


CUBE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n" + (
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
)


@pytest.mark.parametrize("removed", ["package", "work"])
def test_a_package_removed_while_it_is_judged_is_no_verdict(
    removed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The gate finds no file, which is no property of the source: neither the item nor the stage keeps that."""
    (tmp_path / "cube.obj").write_text(CUBE)
    [cube] = discover([tmp_path / "cube.obj"])
    work, out = tmp_path / "out" / ".work" / "cube", tmp_path / "out"

    def process() -> ReportItem:
        options = Options(units="cm")
        return process_source(cube, options=options, simulator=FakeSimulator(), out=out, work_dir=work)

    def gate_without_files(main_file: Path) -> tuple[Diagnostic, ...]:
        shutil.rmtree(work if removed == "work" else main_file.parent.parent)
        return gate(main_file)

    monkeypatch.setattr(judge_package, "gate", gate_without_files)
    lost = process()
    assert lost.outcome is ItemOutcome.REJECTED
    assert lost.codes[-1] == "asset/storage-failed"
    assert "asset/package-invalid" not in lost.codes
    monkeypatch.setattr(judge_package, "gate", gate)
    made = process()
    assert made.packages == ("cube",)
    assert "acceptance" not in made.cached


def test_no_stage_stores_a_result_made_without_the_work_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "cube.obj").write_text(CUBE)
    [cube] = discover([tmp_path / "cube.obj"])
    work, out, run_stage = tmp_path / "out" / ".work" / "cube", tmp_path / "out", NormalizeAppearance.run

    def process() -> ReportItem:
        options = Options(units="cm")
        return process_source(cube, options=options, simulator=FakeSimulator(), out=out, work_dir=work)

    def work_removed(stage: NormalizeAppearance, draft: Draft, tools: Tools) -> Outcome[Appearance]:
        shutil.rmtree(work)
        return run_stage(stage, draft, tools)

    monkeypatch.setattr(NormalizeAppearance, "run", work_removed)
    lost = process()
    assert lost.codes[-1] == "asset/storage-failed"
    assert not list((out / ".cache" / "stages" / "appearance").rglob("*.npz"))


def test_a_source_removed_while_it_is_read_is_missing(sources: Path, tmp_path: Path):
    """The real worker: whatever a reader makes of a file that is gone, the item says that it is gone."""
    source = sources / "a.obj"
    [candidate] = discover([source])
    request = {
        "given": candidate.given,
        "path": str(source),
        "root": str(sources),
        "format": "obj",
        "asset_id": "a",
        "engine": SIMULATOR,
        "options": Options().model_dump(),
        "out": str(tmp_path / "out"),
        "fresh": False,
        "work_dir": str(tmp_path / "work"),
        "note": str(tmp_path / "note.json"),
    }
    source.unlink()
    worker.process_request(request)
    stored = result_store.read_stored(tmp_path / "note.json")
    assert stored is not None
    assert stored.item.codes == ("asset/source-missing",)
    assert "export" not in stored.item.diagnostics[0].help


def test_ctrl_c_stores_finished_items_and_nothing_of_running_ones(sources: Path, tmp_path: Path):
    for name in ("x", "y"):
        (sources / f"{name}.obj").write_text("hang")
    this = batch(tmp_path / "out", placement=Placement(5))
    candidates = discover([sources])
    running = cast(Generator[ReportItem], run_items(candidates, this))
    finished = [next(running) for _ in range(3)]
    running.close()
    assert {Path(i.source).stem for i in finished} == set("abc")
    notes = [result_store.read_stored(result_store.result_file(c, this.out, this.options)) for c in candidates]
    assert sum(n is not None for n in notes) == 3
    assert all(n is None or not n.item.codes for n in notes)
    for name in ("x", "y"):
        (sources / f"{name}.obj").write_text("good")
    assert {i.outcome for i in run(sources, this).values()} == {ItemOutcome.ACCEPTED}


def test_an_unreadable_source_costs_only_its_own_item(sources: Path, tmp_path: Path):
    (sources / "broken.obj").symlink_to(sources / "nowhere.obj")
    items = run(sources, batch(tmp_path / "out"))
    assert items["broken"].codes == ("asset/source-missing",)
    assert {items[n].outcome for n in "abc"} == {ItemOutcome.ACCEPTED}


def test_fresh_and_root_and_code_are_other_results(sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    this = batch(tmp_path / "out")
    run(sources, this)
    assert run(sources, batch(tmp_path / "out", fresh=True))["a"].cached == ()
    wider = {Path(i.source).stem: i for i in run_items(discover([sources], root=tmp_path), this)}
    assert wider["a"].cached == ()
    monkeypatch.setattr(result_store, "library_versions", lambda: {"code": "other"})
    assert run(sources, this)["a"].cached == ()


def package(out: Path, name: str) -> Path:
    folder = out / ".work" / name
    folder.mkdir(parents=True)
    record = json.loads(RECORD_SAMPLE.read_text()) | {"asset_id": name}
    (folder / "record.json").write_text(json.dumps(record))
    return folder


def test_publish_replaces_packages_and_nothing_else(tmp_path: Path):
    assert release.publish(package(tmp_path, "mug"), tmp_path / "mug") is None
    assert release.publish(package(tmp_path, "mug"), tmp_path / "mug") is None
    precious = tmp_path / "bowl" / "precious.blend"
    precious.parent.mkdir()
    precious.write_text("work of a week")
    refused = release.publish(package(tmp_path, "bowl"), tmp_path / "bowl")
    assert refused is not None
    assert refused.code == "asset/output-occupied"
    assert precious.read_text() == "work of a week"


def test_a_package_that_is_no_longer_made_is_withdrawn_and_namesakes_keep_theirs(tmp_path: Path):
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mug.obj").write_text(folder)
    first, second = (discover([tmp_path / f / "mug.obj"])[0] for f in ("one", "two"))
    release.publish(package(tmp_path, "mug"), tmp_path / "mug")
    ownership.record_ownership(first, ["mug"], tmp_path)
    assert ownership.resolve_asset_id(first, tmp_path).asset_id == "mug"
    assert ownership.resolve_asset_id(second, tmp_path).asset_id.startswith("mug-")
    ownership.record_ownership(first, [], tmp_path)
    assert not (tmp_path / "mug").exists()
    assert ownership.resolve_asset_id(second, tmp_path).asset_id == "mug"


def test_the_output_folder_is_no_source(sources: Path, tmp_path: Path):
    out = sources / "library"
    (out / "deep").mkdir(parents=True)
    (out / "deep" / "a.obj").write_text("good")
    assert len(discover([sources], out=out)) == 3


def test_a_file_reached_twice_counts_once(sources: Path):
    assert len(discover([sources, sources / "a.obj", sources / ".." / "in" / "b.obj"])) == 3


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


def test_report_json_has_the_stable_keys(sources: Path, tmp_path: Path):
    this = batch(tmp_path / "out")
    run_batch(discover([sources], out=this.out), this)
    report = json.loads((this.out / "report.json").read_text())
    assert report["schema_version"]
    assert set(report["items"][0]) >= {"source", "outcome", "codes", "packages", "repairs", "seconds"}
    assert report["totals"]["accepted"] == 3
    assert report["items"][0]["source"] == str(sources / "a.obj")
