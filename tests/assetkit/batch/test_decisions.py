"""Decisions of people are kept, replayed on the same content only, and say so wherever they act."""

from __future__ import annotations

import json
import shutil
from functools import partial
from pathlib import Path

import pytest
import trimesh
from typer.testing import CliRunner

from assetkit.batch.decisions import DECISIONS, decision_findings, read_decisions, record_decision, with_decisions
from assetkit.batch.human_acceptance import apply_human_acceptance
from assetkit.batch.item_cells import run_items
from assetkit.batch.report_file import read_report
from assetkit.batch.suite_rows import VIDEOS
from assetkit.library.review import decision_about, main_file
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stage_log import Entry, StageLog
from cli.assets.app import app
from jobs.cache import file_sha256
from schemas.asset import SourceFile
from schemas.decision import Decision
from schemas.diagnostics import InvalidInput, finding
from schemas.outcome import ItemOutcome
from tests.assetkit.test_batch import batch


def decision(file: Path, **said) -> Decision:
    return Decision(**{"source": str(file), "source_sha256": file_sha256(file), "by": "Ann", **said})


@pytest.fixture
def mug(tmp_path: Path) -> Path:
    file = tmp_path / "in" / "mug.obj"
    file.parent.mkdir()
    file.write_text("good")
    return file


def decided(file: Path, *decisions: Decision, **options) -> Options:
    return with_decisions(Options(**options), discover([file])[0], decisions)


def test_decisions_are_only_ever_appended_and_read_back(mug: Path, tmp_path: Path):
    first, second = decision(mug, set={"units": "mm"}), decision(mug, accept=True, known=("asset/open-shell",))
    record_decision(first, tmp_path)
    before = (tmp_path / DECISIONS).read_bytes()
    record_decision(second, tmp_path)
    assert (tmp_path / DECISIONS).read_bytes().startswith(before)
    assert read_decisions(tmp_path) == (first, second)
    assert b"date" not in before


@pytest.mark.parametrize(
    "line", ['{"by": "Bob"}', "{", "", '{"source": "a", "source_sha256": "b", "by": "Bob", "set": {"units": "miles"}}']
)
def test_a_damaged_line_stops_the_batch_and_is_named(line: str, mug: Path, tmp_path: Path):
    record_decision(decision(mug, accept=True), tmp_path)
    with (tmp_path / DECISIONS).open("a") as file:
        file.write(line + "\n")
    with pytest.raises(InvalidInput) as refused:
        read_decisions(tmp_path)
    assert refused.value.diagnostic.code == "asset/decision-unreadable"
    assert refused.value.diagnostic.where.line == 2


def test_a_last_line_left_open_is_closed_before_the_next_decision(mug: Path, tmp_path: Path):
    first, second = decision(mug, accept=True), decision(mug, accept=False)
    record_decision(first, tmp_path)
    path = tmp_path / DECISIONS
    path.write_bytes(path.read_bytes().rstrip(b"\n"))
    record_decision(second, tmp_path)
    assert read_decisions(tmp_path) == (first, second)


def test_a_damaged_report_is_told(tmp_path: Path):
    (tmp_path / "report.json").write_text("{")
    with pytest.raises(InvalidInput) as refused:
        read_report(tmp_path)
    assert refused.value.diagnostic.code == "asset/report-unreadable"


def test_a_decision_is_about_the_object_that_was_named_or_about_none(tmp_path: Path):
    """A file of two objects, of which one package has gone: the decision must not slip onto the other."""
    source, out = tmp_path / "in", tmp_path / "out"
    source.mkdir()
    apart = trimesh.transformations.translation_matrix((1.0, 0.0, 0.0))
    two = trimesh.util.concatenate(
        [trimesh.creation.box((0.2, 0.1, 0.1)), trimesh.creation.box((0.1, 0.1, 0.1), apart)]
    )
    two.export(source / "pair.obj")
    mana("ingest", source, "--out", out, "--json")
    report = read_report(out)
    (item,) = report.items
    assert len(item.packages) == 2
    shutil.rmtree(out / item.packages[1])
    about = partial(decision_about, out, item, set_={}, accept=True, by="Ann", reason="")
    assert (about(item.packages[0]).object, about(item.source).object) == (1, 0)
    with pytest.raises(LookupError, match=item.packages[1]):
        about(item.packages[1])


def test_what_is_decided_overrules_the_command_line_and_says_by_whom(mug: Path):
    options = decided(mug, decision(mug, set={"units": "mm", "category": "mug"}), units="cm")
    resolved = options.of_object(1)
    assert (resolved.units, resolved.category) == ("mm", "mug")
    assert resolved.origin("units") == "decision by Ann"
    assert resolved.origin("license") == "--license"
    codes = [d.code for d in decision_findings(options, 1)]
    assert codes == ["asset/decided-by-person", "asset/decision-overruled"]


def test_of_two_decisions_the_last_wins_and_both_are_named(mug: Path):
    options = decided(mug, decision(mug, set={"units": "mm"}), decision(mug, set={"units": "in"}, by="Bob"))
    assert options.of_object(1).units == "in"
    said = decision_findings(options, 1)[-1]
    assert said.code == "asset/decision-overruled"
    assert "'in' by Bob" in said.headline
    assert "'mm' by Ann" in said.headline


def test_an_empty_value_withdraws_a_statement(mug: Path):
    options = decided(mug, *(decision(mug, set={"units": u, "category": c}) for u, c in (("mm", "mug"), ("", ""))))
    assert (options.of_object(1).units, options.of_object(1).category) == ("auto", None)


def test_a_decision_follows_the_content_and_not_the_name(mug: Path, tmp_path: Path):
    made = decision(mug, set={"units": "mm"})
    moved = Path(shutil.copy(mug, tmp_path / "cup.obj"))
    assert decided(moved, made).of_object(1).units == "mm"
    mug.write_text("changed")
    options = decided(mug, made)
    assert options.of_object(1).units == "auto"
    assert [d.code for d in decision_findings(options, 1)] == ["asset/decision-outdated"]


def test_a_changed_reference_is_another_content(mug: Path):
    colours = mug.with_suffix(".mtl")
    colours.write_text("red")
    made = decision(mug, set={"units": "mm"}, references={"mug.mtl": file_sha256(colours)})
    assert decided(mug, made).decisions == (made,)
    colours.write_text("blue")
    assert decided(mug, made).outdated == (made,)


def test_a_decision_about_one_object_of_several_leaves_the_others_alone(mug: Path):
    options = decided(mug, decision(mug, set={"category": "mug"}, object=2))
    assert [options.of_object(n).category for n in (0, 1, 2)] == [None, None, "mug"]


def test_a_decision_makes_only_its_own_item_anew(mug: Path, tmp_path: Path):
    (mug.parent / "bowl.obj").write_text("good too")
    this = batch(tmp_path / "out")
    candidates = discover([mug.parent])
    list(run_items(candidates, this))
    record_decision(decision(mug, set={"category": "mug"}), this.out)
    again = {Path(i.source).stem: i.cached for i in run_items(candidates, this)}
    assert again == {"bowl": ("item",), "mug": ()}
    assert all(i.cached == ("item",) for i in run_items(candidates, this))


def in_review(*codes: str) -> StageLog:
    return StageLog({"canonicalize": Entry(tuple(finding(code, "odd") for code in codes), review=True)})


def test_acceptance_answers_the_questions_that_the_person_saw(mug: Path):
    knows = decided(mug, decision(mug, accept=True, known=("asset/scale-unverified",)))
    assert apply_human_acceptance(in_review("asset/scale-unverified"), knows).outcome is ItemOutcome.ACCEPTED
    unseen = apply_human_acceptance(in_review("asset/scale-unverified", "asset/open-shell"), knows)
    assert unseen.outcome is ItemOutcome.REVIEW
    assert unseen.diagnostics[-1].code == "asset/decision-outdated"
    assert "asset/open-shell" in unseen.diagnostics[-1].headline


def test_acceptance_can_be_withdrawn_and_never_covers_errors(mug: Path):
    made = decision(mug, accept=True, known=("asset/scale-unverified", "asset/no-faces"))
    withdrawn = decided(mug, made, decision(mug, accept=False, by="Bob"))
    assert apply_human_acceptance(in_review("asset/scale-unverified"), withdrawn).outcome is ItemOutcome.REVIEW
    rejected = apply_human_acceptance(in_review("asset/no-faces"), decided(mug, made))
    assert rejected.outcome is ItemOutcome.REJECTED


@pytest.mark.parametrize(
    ("source", "main"),
    [("in/b/x.gltf", "b/x.gltf"), ("x.gltf", "x.gltf"), ("/data/in/a/x.gltf", "a/x.gltf"), ("x.bin", "x.bin")],
)
def test_the_main_file_is_found_among_all_that_were_read(source: str, main: str):
    files = [SourceFile(path=p, sha256="", bytes=0) for p in ("a/x.gltf", "b/x.gltf", "x.bin", "x.gltf")]
    assert main_file(files, source).path == main


def mana(*words: object) -> str:
    ran = CliRunner().invoke(app, list(map(str, words)))
    assert ran.exit_code == 0, ran.output
    return ran.stdout


def test_review_and_search_of_a_real_file_from_end_to_end(bullet_data: Path, tmp_path: Path):
    """A duck of 1.65 units: no toy of that size in metres, so its category needs a decision, which a person makes."""
    source, out = tmp_path / "in", tmp_path / "out"
    source.mkdir()
    for name in ("duck.obj", "duck.mtl", "duckCM.png"):
        shutil.copy(bullet_data / name, source)
    again = ("ingest", source, "--out", out, "--require-category", "--json")
    assert json.loads(mana(*again))["items"][0]["outcome"] == "review"
    (question,) = json.loads(mana("review", out, "--json"))
    category = next(d for d in question["doubts"] if d["field"] == "category")
    assert [c["value"] for c in category["candidates"]] == ["toy_figure"]
    assert "duck/previews/view_front.png" in question["pictures"]
    assert json.loads(mana("search", out, "yellow duck", "--category", "toy_figure", "--json"))["hits"] == []
    said = ("--set", "category=toy_figure", "--set", "units=in", "--by", "Ann", "--reason", "a bath toy")
    mana("review", out, "duck.obj", *said)
    film = out / VIDEOS / "duck.gif"
    assert film.name not in (out / ".report" / "00000.js").read_text()
    film.parent.mkdir()
    film.touch()
    item = json.loads(mana(*again))["items"][0]
    (page,) = json.loads((out / ".report" / "00000.js").read_text().removeprefix("details(0, ").removesuffix(");\n"))
    assert f'href="{VIDEOS}/duck.gif"' in page  # The film is left alone and linked.
    assert "<td>common</td>" in page
    assert (item["outcome"], [r["name"] for r in item["repairs"]]) == ("repaired", ["turn_upright"])  # It lay.
    assert "asset/decided-by-person" in item["codes"]
    record = json.loads((out / "duck" / "record.json").read_text())
    assert record["semantics"]["category"] | {"inputs": []} == {
        "value": "toy_figure", "source": "declared", "method": "decision by Ann",
        "confidence": 1.0, "bounds": None, "inputs": [],
    }  # fmt: skip
    assert record["source"]["meters_per_unit"]["value"] == 0.0254
    assert json.loads(mana("review", out, "--json")) == []
    (hit,) = json.loads(mana("search", out, "yellow duck under 10 cm", "--json"))["hits"]
    assert {w["words"]: w["field"] for w in hit["why"]} == {
        "duck": "semantics.category", "yellow": "appearance.colours", "under 10 cm": "geometry.extent_m",
    }  # fmt: skip
