"""`mana assets render`: modes of a source file and of a package, sizes, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from cli.main import app
from tests.support.bad_inputs.assets import CUBE, obj_text
from tests.support.gate_packages import cabinet, prop

MODES = ("beauty", "wire", "parts", "collision", "physics")


def run(*arguments: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["assets", "render", *map(str, arguments)])
    return result.exit_code, result.output


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "part.obj"
    path.write_text(obj_text(CUBE))
    return path


def test_a_source_file_from_all_around(source: Path, tmp_path: Path) -> None:
    code, printed = run(source, "--mode", "all", "--views", 3, "--size", 64, "--out", tmp_path / "out", "--json")
    assert code == 0, printed
    sides = {f"{mode}_{turn}.png" for mode in ("beauty", "wire") for turn in ("000", "120", "240")}
    written = [Path(path) for path in json.loads(printed)]
    assert {path.name for path in written} == sides | {"beauty.png", "wire.png"}
    assert all(Image.open(tmp_path / "out" / name).size == (64, 64) for name in sides)


def test_a_package_in_every_mode(tmp_path: Path) -> None:
    package = prop(tmp_path).parents[1]
    code, printed = run(package, "--mode", "all", "--size", 64, "--out", tmp_path / "out", "--json")
    assert code == 0, printed
    assert {Path(path).name for path in json.loads(printed)} >= {f"{mode}.png" for mode in MODES}


def test_the_looks_of_a_package_do_not_need_its_joints(tmp_path: Path) -> None:
    """Another maker's joint to the world, which is refused where physics is drawn, and named."""
    package = cabinet(tmp_path).parents[1]
    assert run(package, "--size", 64, "--out", tmp_path / "out")[0] == 0
    code, _ = run(package, "--mode", "physics", "--size", 64, "--out", tmp_path / "none")
    assert code != 0
    assert not (tmp_path / "none" / "physics.png").exists()


@pytest.mark.parametrize("mode", ["parts", "collision", "physics"])
def test_a_source_file_has_no_physics_yet(mode: str, source: Path, tmp_path: Path) -> None:
    code, printed = run(source, "--mode", mode, "--out", tmp_path / "out")
    assert code == 2
    assert "packages only" in " ".join(printed.split())
    assert not (tmp_path / "out").exists()


def test_an_unknown_mode_names_the_known_ones(source: Path) -> None:
    code, printed = run(source, "--mode", "x-ray")
    assert code == 2
    assert "physics" in printed
