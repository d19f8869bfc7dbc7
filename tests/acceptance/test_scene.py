"""`mana scene` over whole programs: files, verdicts, exit codes, and the words that a person reads."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from cli.main import app
from gate.external_validators import usd_validation
from schemas.scene.compiled import CompiledScene, CompileReport

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenes"
SMALL = """\
scene: small
background: {asset: {type: box, size_m: [0.5, 0.4, 0.04]}}
anchors: {top: {object: background, surface: auto}}
objects: [{id: cube, asset: {type: box, size_m: [0.05, 0.05, 0.05]}}]
layout:
  nodes:
    a: {object: cube, placement: {type: surface, surface: top}}
    b: {object: cube, placement: {type: surface, surface: top, ranges: {x: [0.1, 0.1]}}}
"""


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["scene", *map(str, arguments)])


def small(folder: Path, more: str = "", name: str = "small.yaml") -> Path:
    file = folder / name
    file.write_text(SMALL + more)
    return file


def test_a_scene_is_written_checked_and_stays(tmp_path: Path):
    out = tmp_path / "out"
    result = run("compile", small(tmp_path), "--out", out, "--emit", "graph", "--json")
    assert result.exit_code == 0, result.output
    report = CompileReport.model_validate_json(result.stdout)
    assert (report.verdict, report.scene) == ("compiled", "scene.usda")
    assert {row.id for row in report.settling} == {"a", "b"}
    assert all(row.stayed for row in report.settling)
    assert {*report.phases} >= {"read", "bind", "solve", "check", "emit"}
    assert CompileReport.model_validate_json((out / "report.json").read_bytes()) == report
    scene = CompiledScene.model_validate_json((out / "scene.json").read_bytes())
    assert [item.id for item in scene.objects] == ["a", "b"]
    assert usd_validation(out / "scene.usda").passed
    graph = json.loads((out / "graph.json").read_bytes())
    assert {node["name"] for node in graph["nodes"]} >= {"a", "b"}
    assert (out / "graph.dot").read_text().startswith("digraph")
    for name in ("plan.png", "perspective.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")


def test_same_program_and_seed_same_bytes_another_seed_another_scene(tmp_path: Path):
    program = small(tmp_path)
    made = []
    for number, seed in enumerate((0, 0, 1)):
        out = tmp_path / str(number)
        assert run("compile", program, "--out", out, "--seed", str(seed), "--no-settle", "--no-pictures").exit_code == 0
        made.append([(out / f"scene.{kind}").read_bytes() for kind in ("json", "usda")])
    assert made[0] == made[1]
    assert made[0] != made[2]


def test_a_program_with_mistakes_shows_all_of_them_at_their_lines(tmp_path: Path):
    program = small(tmp_path, "relations: [{left_off: [a, b]}, {left_of: [a, b], gap: -1}]\n")
    result = run("diagnose", program)
    assert result.exit_code == 1
    assert "error[scene/unknown-key]" in result.output
    assert "small.yaml:9:" in result.output
    assert "9 | relations: [{left_off: [a, b]}, {left_of: [a, b], gap: -1}]" in result.output
    assert "invalid program" in result.output


def test_a_failure_leaves_no_scene_of_an_earlier_run(tmp_path: Path):
    out = tmp_path / "out"
    assert run("compile", small(tmp_path), "--out", out, "--no-settle", "--no-pictures").exit_code == 0
    wrong = small(tmp_path, "clearance: much\n", "wrong.yaml")
    result = run("compile", wrong, "--out", out, "--json")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["verdict"] == "invalid_program"
    assert not list(out.glob("scene*"))


def test_files_of_the_user_stay_in_the_folder(tmp_path: Path):
    program = small(tmp_path, name="scene.yaml")
    for name in ("scene-kitchen.yaml", "graph.yaml", "scene.json", "scene.usd"):
        (tmp_path / name).write_text("mine")
    assert run("diagnose", program).exit_code == 0
    assert run("compile", small(tmp_path, "clearance: much\n", "scene-2.yaml"), "--out", tmp_path).exit_code == 1
    assert {file.name for file in tmp_path.iterdir()} == {
        "scene.yaml", "scene-2.yaml", "scene-kitchen.yaml", "graph.yaml", "scene.json", "scene.usd", "report.json",
    }  # fmt: skip


def test_a_picture_of_an_earlier_run_does_not_stay(tmp_path: Path):
    assert run("render", small(tmp_path), "--out", tmp_path / "out").exit_code == 0
    assert run("render", EXAMPLES / "three_cycle.yaml", "--out", tmp_path / "out").exit_code == 1
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["failure.png"]
    result = run("render", small(tmp_path, "clearance: much\n", "wrong.yaml"), "--out", tmp_path / "none")
    assert result.exit_code == 1
    assert "picture:" not in result.output


def test_examples_in_the_help_exist():
    for command in ("compile", "diagnose", "render"):
        words = " ".join(run(command, "--help").output.split())
        found = re.search(r"examples/scenes/\w+\.yaml", words)
        assert found is not None
        assert (EXAMPLES / Path(found[0]).name).is_file()


def test_missing_files_end_with_2(tmp_path: Path):
    assert run("compile", tmp_path / "none.yaml", "--out", tmp_path).exit_code == 2


def test_codes_are_explained():
    result = run("explain", "scene/relation-cycle")
    assert result.exit_code == 0
    assert "circle" in result.output


def test_the_schema_is_json_schema():
    import jsonschema

    schema = json.loads(run("schema").stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert "layout" in schema["properties"]


@pytest.mark.parametrize("name", ["stacked_plates", "rack_slots"])
def test_examples_without_packages_compile_and_stay(name: str, tmp_path: Path):
    result = run("compile", EXAMPLES / f"{name}.yaml", "--out", tmp_path, "--json", "--no-pictures")
    assert result.exit_code == 0, result.output
    report = CompileReport.model_validate_json(result.stdout)
    assert all((tmp_path / str(row.scene)).is_file() for row in report.matrix)
