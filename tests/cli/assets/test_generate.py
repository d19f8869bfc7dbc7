"""`mana assets generate`: lists, sources with truth, and mistakes that name key, value and both bounds."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from assetkit.generate.table import GENERATORS
from assetkit.generate.truth import TRUTH_FILE, GeneratedTruth
from cli.assets.app import app


def run(*words: str) -> Result:
    return CliRunner().invoke(app, ["generate", *words], env={"COLUMNS": "200", "TERM": "dumb"})


def test_all_generators_are_listed_with_their_parameters() -> None:
    rows = json.loads(run("--list", "--json").stdout)
    assert [row["name"] for row in rows] == list(GENERATORS)
    (width,) = [p for row in rows if row["name"] == "drawer_unit" for p in row["parameters"] if p["name"] == "width_m"]
    assert (width["default"], width["low"], width["high"], width["unit"]) == (0.4, 0.25, 1.0, "m")
    shown = run("--list").stdout
    assert "drawer_unit" in shown
    assert "level_height_m" in shown


def test_parameters_of_one_are_listed_with_unit_and_range() -> None:
    shown = run("microwave", "--list").stdout
    assert "1.3 to 2.2 rad" in shown
    assert "one of knob, button" in shown
    (control,) = [p for p in json.loads(run("microwave", "--list", "--json").stdout) if p["name"] == "control"]
    assert control["choices"] == ["knob", "button"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["drawr_unit"], "did you mean drawer_unit?"),
        (["drawer_unit", "--set", "wdth_m=1"], "did you mean width_m"),
        (["drawer_unit", "--set", "width_m=3"], "width_m must be 0.25 to 1 m; found 3"),
        (["microwave", "--set", "control=nob"], "did you mean knob?"),
        ([], "--list shows all"),
    ],
)
def test_mistakes_are_refused_with_exit_code_2(words: list[str], message: str, tmp_path: Path) -> None:
    done = run(*words, "--out", str(tmp_path / "out"))
    assert done.exit_code == 2
    assert message in " ".join(done.output.replace("│", " ").split())
    assert not (tmp_path / "out").exists()


def test_sources_only_are_written_with_truth_and_written_anew(tmp_path: Path) -> None:
    first = run("blocks", "--set", "blocks=3", "--source-only", "--out", str(tmp_path), "--json")
    assert first.exit_code == 0
    assert [Path(file).name for file in json.loads(first.stdout)["sources"]] == [
        "red_block.urdf",
        "green_block.urdf",
        "blue_block.urdf",
    ]
    run("blocks", "--set", "blocks=1", "--source-only", "--out", str(tmp_path))
    folder = tmp_path / "sources" / "blocks"
    assert [file.name for file in folder.glob("*.urdf")] == ["red_block.urdf"]
    truth = GeneratedTruth.model_validate_json((folder / TRUTH_FILE).read_bytes())
    assert truth.parameters["blocks"].value == 1
    assert truth.parameters["edge_m"].unit == "m"


def test_a_folder_that_no_generator_wrote_is_left_alone(tmp_path: Path) -> None:
    mine = tmp_path / "sources" / "blocks"
    mine.mkdir(parents=True)
    (mine / "red_block.urdf").write_text("mine")
    done = run("blocks", "--source-only", "--out", str(tmp_path))
    assert done.exit_code == 2
    assert (mine / "red_block.urdf").read_text() == "mine"


def test_a_name_becomes_that_of_the_source(tmp_path: Path) -> None:
    run("turntable", "--name", "Lazy Susan", "--source-only", "--out", str(tmp_path))
    assert (tmp_path / "sources" / "lazy_susan" / "lazy_susan.urdf").is_file()
