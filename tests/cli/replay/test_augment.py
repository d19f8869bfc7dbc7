"""`mana replay augment` as users run it: a folder of recordings, variants that the verifier passes, resumed batches."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.main import app
from cli.replay.render_cell import draw
from jobs.cell import Limits
from replay.augment_worker import augment as augmented
from replay.run import distinct_prefixes
from replay.verification.check_output import check_output, summary
from scenec.plan.document import plan_text
from schemas.diagnostics import InvalidInput
from tests.support.plan.library import tray_plan
from tests.support.replay_samples import robomimic, staged

run = CliRunner().invoke


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> Path:
    """A folder of two recordings and of something else."""
    folder = tmp_path_factory.mktemp("recordings")
    staged(folder / "one")
    robomimic(folder / "two.hdf5", demos=1)
    (folder / "notes.txt").write_text("no recording")
    return folder


@pytest.fixture(scope="module")
def plan(tmp_path_factory) -> Path:
    """The boxes of the tray scene, as a plan on disk; none of them needs a package."""
    first, second = tray_plan().combinations[:2]
    boxes = first.model_copy(update={"things": second.things, "pools": second.pools})
    kept = tray_plan().model_copy(update={"combinations": (boxes,)})
    file = tmp_path_factory.mktemp("plan") / "plan.json"
    file.write_text(plan_text(kept))
    return file


def augment(recordings: Path, plan: Path, out: Path, *more: str):
    words = ["replay", "augment", str(recordings), "--plan", str(plan), "--out", str(out), "--variants", "2", "--json"]
    return run(app, [*words, "--objects", "2", *more])


def test_a_folder_of_recordings_becomes_variants_that_pass_the_verifier(recordings, plan, tmp_path):
    """And what is finished is not done again."""
    out = tmp_path / "out"
    made = augment(recordings, plan, out)
    assert made.exit_code == 0, made.output
    rows = json.loads(made.stdout)["episodes"]
    assert [row["variants"] for row in rows] == [2, 2]
    files = sorted(out.glob("*/variant_*/variant.json"))
    assert len(files) == 4
    stamps = [file.stat().st_mtime_ns for file in files]
    assert json.loads(augment(recordings, plan, out).stdout)["episodes"] == rows
    assert [file.stat().st_mtime_ns for file in files] == stamps
    said = summary(check_output(out, None, None))
    assert said["variants"] == said["sound"] == 4
    assert said["objects_inserted"]["min"] == 2
    assert said["states_identical"]


def given(recordings: Path, plan: Path, out: Path, **options):
    asked = {"variants": 1, "objects": 2, "seed": 0, "clearance_m": 0.01, "most_hidden": 1.0} | options
    nothing = dict.fromkeys(("assets", "meshes", "scene"))
    return {
        "candidates": "cli.replay.candidates:candidates",
        "source": str(recordings / "one"),
        "prefix": "",
        "plan": str(plan),
        "out": str(out),
        "supports": [],
        "options": asked,
    } | nothing


def test_equal_seeds_give_equal_variants_and_others_others(recordings, plan, tmp_path):
    texts = []
    for name, seed in (("first", 0), ("second", 0), ("third", 1)):
        augmented(given(recordings, plan, tmp_path / name, seed=seed))
        texts.append(next((tmp_path / name).glob("*/variant_*/variant.json")).read_bytes())
    assert texts[0] == texts[1] != texts[2]


def test_variants_are_drawn_once_and_within_the_limit_of_what_they_hide(recordings, plan, tmp_path):
    out = tmp_path / "out"
    words = ["--variants", "1", "--render", "--every", "6", "--cameras", "front", "--most-hidden", "0.1"]
    made = augment(recordings / "one", plan, out, *words)
    assert made.exit_code == 0, made.output
    [row] = json.loads(made.stdout)["episodes"]
    assert (row["variants"], row["frames"]) == (1, 2)
    assert row["most_hidden"] <= 0.1
    pictures = sorted(out.rglob("*.png"))
    assert len(pictures) == 2 * 3
    assert {file.parts[-3:-1] for file in pictures} == {("front", kind) for kind in ("rgb", "depth", "instances")}
    stamps = [file.stat().st_mtime_ns for file in pictures]
    asked = {"out": str(out), "folder": str(out / "one" / "variant_0000"), "meshes": None, "every": 6}
    assert draw({**asked, "cameras": ["front"]})["frames"] == 2
    with pytest.raises(InvalidInput) as refused:
        draw({**asked, "cameras": ["moon"]})
    assert refused.value.diagnostic.code == "replay/missing-camera"
    assert [file.stat().st_mtime_ns for file in pictures] == stamps


def test_what_has_no_room_is_told_with_who_takes_it(recordings, plan, tmp_path):
    [row] = augmented(given(recordings, plan, tmp_path, objects=9, clearance_m=0.25))["rows"]
    assert row["short_variants"] == 1
    assert row["diagnostics"][0]["code"] == "replay/no-room"
    said = row["diagnostics"][0]["headline"]
    assert "of 9 objects" in said
    assert "was free up to" in said
    assert "most is swept by" in said


def test_another_scene_is_another_job_and_a_strange_note_is_not_replaced(recordings, plan, tmp_path):
    asked = given(recordings, plan, tmp_path) | {"source": str(recordings / "two.hdf5")}
    [first] = augmented(asked)["rows"]
    assert augmented(asked)["rows"] == [first]
    scene = tmp_path / "scene.json"
    scene.write_text("{}")
    [second] = augmented(asked | {"scene": str(scene)})["rows"]
    assert second["key"] != first["key"]
    next(tmp_path.glob("*/augmented.json")).write_text("[]")
    with pytest.raises(InvalidInput) as refused:
        augmented(asked)
    assert refused.value.diagnostic.code == "replay/out-taken"


def test_nothing_to_put_in_is_refused(recordings, plan, tmp_path):
    with pytest.raises(InvalidInput) as refused:
        augmented(given(recordings, plan, tmp_path) | {"plan": None})
    assert refused.value.diagnostic.code == "replay/no-candidates"


def test_what_is_no_recording_and_what_takes_too_long_stop_only_themselves(recordings, plan, tmp_path, monkeypatch):
    monkeypatch.setattr("replay.run.LIMITS", Limits(seconds=0.05, memory_mb=8192))
    made = augment(recordings / "one", plan, tmp_path / "out")
    assert made.exit_code == 1
    assert json.loads(made.stdout)["refused"][0]["diagnostic"]["code"] == "replay/stopped"


def test_recordings_of_one_name_have_folders_of_their_own():
    sources = [Path("lift/demo.hdf5"), Path("stack/demo.hdf5"), Path("door.hdf5")]
    assert list(distinct_prefixes(sources).values()) == ["lift_", "stack_", ""]


def test_nothing_that_mana_did_not_make_of_this_recording_is_deleted(recordings, plan, tmp_path):
    """Not the recording itself where --out is the folder it lies in, nor variants of another one."""
    source = staged(tmp_path / "demos" / "one")
    before = sorted(source.rglob("*"))
    asked = given(recordings, plan, tmp_path / "demos") | {"source": str(source)}
    with pytest.raises(InvalidInput) as refused:
        augmented(asked)
    assert refused.value.diagnostic.code == "replay/out-taken"
    assert sorted(source.rglob("*")) == before
    out = tmp_path / "out"
    augmented(asked | {"out": str(out)})
    with pytest.raises(InvalidInput) as refused:
        augmented(given(recordings, plan, out))
    assert refused.value.diagnostic.code == "replay/out-taken"
    assert "has variants of" in refused.value.diagnostic.headline
