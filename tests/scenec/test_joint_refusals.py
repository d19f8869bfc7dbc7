"""What programs may not say of joints: the finding has its code and the place where it is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenec.bind.asset_library import AssetLibrary
from tests.support.scene.articulated import articulated_library
from tests.support.scene.joint_programs import CLEAR, CUBE, DRAWERS, OVEN, compiled


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(articulated_library(tmp_path_factory.mktemp("library")))


@pytest.mark.parametrize(("rule", "code", "path"), [
    ("{object: oben, joint: door}", "scene/unknown-name", "object"),
    ("{object: oven, joint: dor}", "scene/unknown-joint", "joint"),
    ("{object: box, joint: door}", "scene/unknown-joint", "joint"),
    ("{object: oven, joint: turn}", "scene/no-swept-volume", "joint"),
])  # fmt: skip
def test_what_cannot_be_kept_clear_is_told_where_it_is_written(
    library: AssetLibrary, tmp_path: Path, rule: str, code: str, path: str
):
    text = OVEN + f"keep_clear:\n  - {rule}\n"
    (finding,) = compiled(text, tmp_path, library).report.diagnostics
    assert finding.code == code
    line = text.splitlines()[-1]
    assert (finding.where.line, finding.where.column) == (text.count("\n"), line.index(f"{path}: ") + len(path) + 3)


def test_a_joint_beyond_its_limits_is_told_where_it_is_written(library: AssetLibrary, tmp_path: Path):
    text = OVEN.replace("turn: 0.4", "turn: 0.4, door_deg: 130")
    (finding,) = compiled(text, tmp_path, library).report.diagnostics
    assert finding.code == "scene/joint-range"
    line = next(k for k, row in enumerate(text.splitlines(), 1) if "door_deg" in row)
    assert finding.where.line == line


def test_a_range_of_positions_is_no_position(library: AssetLibrary, tmp_path: Path):
    text = OVEN.replace("turn: 0.4", "turn: [0, 0.4]")
    (finding,) = compiled(text, tmp_path, library).report.diagnostics
    assert finding.code == "scene/joint-state-range"
    assert "joints.turn" in finding.headline


def test_an_unknown_volume_is_answered_with_those_there_are(library: AssetLibrary, tmp_path: Path):
    text = (DRAWERS % (CUBE, "")).replace("volume: drawer_1/inside", "volume: drawer_3/inside")
    (finding,) = compiled(text, tmp_path, library).report.diagnostics
    assert finding.code == "scene/missing-anchor"
    assert "drawer_1/inside, drawer_2/inside" in finding.headline


def test_an_owner_of_a_swept_space_stays_upright(library: AssetLibrary, tmp_path: Path):
    text = OVEN.replace("surface: floor}}\n    dish", "surface: floor, orientation: stable}}\n    dish").replace(
        "    dish: {object: dish, placement: {type: surface, surface: plate}}\n",
        "    dish: {object: dish, placement: {type: surface, surface: floor}}\n",
    )
    codes = [d.code for d in compiled(text + CLEAR, tmp_path, library).report.diagnostics]
    assert codes == ["scene/owner-not-upright"]
