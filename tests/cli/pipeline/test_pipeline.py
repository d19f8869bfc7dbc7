"""`mana pipeline` as a user runs it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from ruamel.yaml import YAML
from typer.testing import CliRunner

from cli.main import app
from tests.support.bad_inputs.pipeline import SOUND, sample, write


def run(*arguments: object) -> tuple[int, str]:
    """Exit code and output."""
    result = CliRunner().invoke(app, ["pipeline", *map(str, arguments)])
    return result.exit_code, result.stdout


def test_a_sound_pipeline_is_checked_explained_and_lowered(tmp_path: Path) -> None:
    file = write(SOUND, tmp_path)
    code, output = run("check", file)
    assert code == 0
    assert "1 scene, 1 robot, 1 task, 1 assembly, 1 rollout" in output
    assert "@pickable is cup" in run("explain", file)[1]
    assert '"scene desk" -> "assembly env";' in run("graph", file)[1]
    orders = json.loads(run("orders", file)[1])
    assert orders["assemblies"][0]["bindings"] == {"@pickable": ["cup"]}
    assert run("orders", file) == run("orders", file)


def test_an_unsound_pipeline_is_shown_with_its_line_and_has_no_orders(tmp_path: Path) -> None:
    file = write(sample("pipeline/unknown-name"), tmp_path)
    code, output = run("check", file)
    assert code == 1
    assert "env_ref: environment" in output
    assert run("orders", file)[0] == 1
    code, output = run("check", file, "--json")
    document = json.loads(output)
    assert (code, document["sound"], document["orders"]) == (1, False, [])
    assert document["diagnostics"][0]["code"] == "pipeline/unknown-name"


@pytest.mark.parametrize("command", ["check", "explain", "graph", "orders"])
def test_every_command_has_json(command: str, tmp_path: Path) -> None:
    code, output = run(command, write(SOUND, tmp_path), "--json")
    assert code == 0
    json.loads(output)


def test_export_writes_what_arena_holds_and_names_the_rest(tmp_path: Path) -> None:
    text = SOUND.replace("{type: cylinder, radius_m: 0.04, height_m: 0.1}", "cup_a")
    text = text.replace("_func: upright, object", "_func: held_by, object")
    file = write(text, tmp_path)
    code, output = run("export", file, "--out", tmp_path / "arena", "--json")
    (row,) = json.loads(output)["environments"]
    assert (code, row["file"]) == (1, None)
    assert "the object `can`: an inline shape is no package" in row["lost"]
    code, output = run("export", file, "--out", tmp_path / "arena", "--lossy")
    assert code == 0
    assert "not held: the background" in output
    document = YAML(typ="safe").load(tmp_path / "arena" / "env.yaml")
    assert document["task"]["subtasks"][0]["kind"] == "LiftObjectTask"
    assert document["objects"][0]["params"]["usd_path"] == "packages/cup_a/usd/cup_a.usda"
