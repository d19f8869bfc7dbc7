"""`mana assets synthesize`: a program's mesh becomes a package whose record names the program and its light mesh."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
import trimesh
from typer.testing import CliRunner

from cli.main import app

MODEL = """
import sys
import trimesh
trimesh.creation.icosphere(4, 0.04).export(sys.argv[2] + "/ball.glb")
"""


def run(folder: Path, *arguments: str):
    out = ["--out", str(folder / "library")]
    return CliRunner().invoke(app, ["assets", "synthesize", *arguments, *out])


def test_text_becomes_a_package_of_a_light_mesh_with_its_origin(tmp_path: Path) -> None:
    script = tmp_path / "my_model.py"
    script.write_text(MODEL)
    command = f'{sys.executable} "{script}"'
    result = run(tmp_path, "A red ball!", "--model", command, "--retopo", "800", "--category", "ball", "--json")
    assert result.exit_code == 0, result.output
    (item,) = json.loads(result.stdout)["report"]["items"]
    record = json.loads((tmp_path / "library" / item["packages"][0] / "record.json").read_text())
    assert record["source"]["author"]["value"] == "generative model 'my_model.py'"
    assert record["retopology"]["triangles_before"] == len(trimesh.creation.icosphere(4).faces)
    assert record["retopology"]["triangles_after"] <= 800
    assert "asset/retopology" in item["codes"]


@pytest.mark.parametrize(
    ("arguments", "code", "why"),
    [
        (("", "--model", "python"), 2, "is needed, or --image"),
        (("ball", "--model", "no-such-program"), 2, "names no program"),
        (("ball", "--model", sys.executable, "--image", "none.png"), 2, "must be a file"),
        (("ball", "--model", sys.executable, "--retopo", "5"), 2, "at least 64"),
        (("ball", "--model", sys.executable, "--units", "miles"), 2, "must be one of"),
    ],
)
def test_what_cannot_run_is_refused(tmp_path: Path, arguments: tuple[str, ...], code: int, why: str) -> None:
    result = run(tmp_path, *arguments)
    assert result.exit_code == code
    assert why in " ".join(result.output.replace("│", " ").split())


def test_a_folder_of_something_else_is_not_emptied(tmp_path: Path) -> None:
    mine = tmp_path / "library/sources/ball/notes.txt"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    result = run(tmp_path, "ball", "--model", sys.executable)
    assert (result.exit_code, mine.read_text()) == (2, "mine")
