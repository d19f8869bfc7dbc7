"""A sample as a USD layer, read back as a simulator would."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from cli.main import app
from geom.pose import pose_from_quat
from runtime_plan import load, sample
from usdio.reread.scene import reread_scene

PROGRAM = """
scene: desk
background: {asset: {type: box, size_m: [1.0, 0.7, 0.04]}}
anchors: {tabletop: {object: background, surface: auto}, inside: {object: tray, surface: auto}}
objects:
  - {id: tray, asset: {type: box, size_m: [0.3, 0.25, 0.02]}}
  - {id: block, asset: {type: box, size_m: [0.06, 0.05, 0.04], mass_kg: 0.1}}
layout:
  nodes:
    tray: {object: tray, placement: {type: surface, surface: tabletop}}
    block: {object: block, placement: {type: surface, surface: inside}}
variants:
  materials:
    - {id: oak, objects: [background], base_color: [0.5, 0.4, 0.2], static_friction: 0.7, dynamic_friction: 0.65}
    - {id: lead, objects: [block], base_color: [0.3, 0.3, 0.3], density_kgm3: 11340, dynamic_friction: 0.3}
    - {id: blue, objects: [block], base_color: [0.1, 0.2, 0.8], roughness: 0.4}
  lighting:
    - {id: noon, intensity: [900, 1100], temperature_K: [5000, 6000], rotation: [0.0, 3.0]}
    - {id: dusk, intensity: [100, 200]}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("desk")
    (place / "desk.yaml").write_text(PROGRAM)
    asked = ["scene", "compile", str(place / "desk.yaml"), "--out", str(place / "out"), "--no-settle", "--no-pictures"]
    run = CliRunner().invoke(app, asked)
    assert run.exit_code == 0, run.output
    return place / "out"


def test_layers_hold_the_sample(folder: Path):
    run = CliRunner().invoke(app, ["plan", "realise", str(folder / "plan.json"), "--n", "12", "--seed", "4", "--json"])
    assert run.exit_code == 0, run.output
    files = [Path(name) for name in json.loads(run.stdout)["files"]]
    plan = load(folder / "plan.json")
    drawn = sample(plan, 12, 4)
    compiled = {body.name: body for body in reread_scene(folder / "scene.usda")}
    seen = set()
    for k, file in enumerate(files):
        bodies = {body.name: body for body in reread_scene(file)}
        for column, name in enumerate(drawn.names):
            wanted = pose_from_quat(drawn.quat_wxyz[k, column], drawn.position_m[k, column])
            np.testing.assert_allclose(bodies[name].X_WA, wanted, atol=1e-9)
        worn = int(drawn.material[k, drawn.names.index("block")])
        block, own = bodies["block"].body, compiled["block"].body
        density_factor = 11340 * 0.06 * 0.05 * 0.04 / 0.1 if worn == 1 else 1.0
        assert block.mass.mass_kg == pytest.approx(density_factor * own.mass.mass_kg, rel=1e-6)
        np.testing.assert_allclose(block.mass.inertia_kgm2, density_factor * own.mass.inertia_kgm2, rtol=1e-5)
        assert block.contact.dynamic_friction == pytest.approx(0.3 if worn == 1 else own.contact.dynamic_friction)
        oak = drawn.background_material[k] == 0
        assert bodies["background"].body.contact.static_friction == pytest.approx(0.7 if oak else 0.6)
        seen.add((worn, bool(oak)))
    assert len(seen) > 3


def test_a_layer_of_a_combination_without_scene_is_refused(folder: Path, tmp_path: Path):
    (tmp_path / "plan.json").write_bytes((folder / "plan.json").read_bytes())
    run = CliRunner().invoke(app, ["plan", "realise", str(tmp_path / "plan.json")])
    assert run.exit_code == 1
    assert run.exception is not None
    assert "scene.usda" in str(run.exception)


def test_pictures_are_drawn(folder: Path, tmp_path: Path):
    sheet, cells = tmp_path / "sheet.png", tmp_path / "cells.png"
    drawn = CliRunner().invoke(app, ["plan", "render", str(folder / "plan.json"), "--n", "2", "--out", str(sheet)])
    assert drawn.exit_code == 0, drawn.output
    asked = ["plan", "inspect", str(folder / "plan.json"), "--out", str(cells), "--json"]
    looked = CliRunner().invoke(app, asked)
    told = json.loads(looked.stdout)
    assert {row["thing"] for row in told["things"]} == {"tray", "block"}
    for row in told["things"]:  # in numbers, so that a script need not take words apart
        assert min(row["cell_m"]) > 0.0
        assert 0.0 <= row["yaw_rad"] <= 7.0
    for row in told["pools"]:
        assert sum(row["families"].values()) == row["cases"]
        assert 0.0 <= row["quality"]["least"] <= row["quality"]["median"] <= row["quality"]["most"] <= 1.0
    with Image.open(sheet) as picture:
        assert picture.size == (658, 332)
        assert np.asarray(picture.convert("L")).min() < 128
    with Image.open(cells) as picture:
        assert picture.width > 1000
    assert not list(folder.glob(".sheet*"))


def test_a_restricted_plan_lies_over_the_scene_of_its_own_combination(tmp_path: Path):
    small = "variants:\n  backgrounds: [{id: small, background: {asset: {type: box, size_m: [0.6, 0.6, 0.3]}}}]\n"
    (tmp_path / "desk.yaml").write_text(PROGRAM.replace("variants:\n", small))
    out, kept = tmp_path / "out", tmp_path / "out" / "small.json"
    run = CliRunner().invoke
    words = ["scene", "compile", str(tmp_path / "desk.yaml"), "--out", str(out), "--no-settle", "--no-pictures"]
    assert run(app, words).exit_code == 0
    words = ["plan", "restrict", str(out / "plan.json"), "--choice", "variants.backgrounds=small", "--out", str(kept)]
    assert run(app, words).exit_code == 0
    made = run(app, ["plan", "realise", str(kept), "--json"])
    assert made.exit_code == 0, made.output
    assert "scene-2.usda" in Path(json.loads(made.stdout)["files"][0]).read_text()
