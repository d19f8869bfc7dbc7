"""`facing` by a part: the direction of the part in the record points at the other, in the scene and in every draw."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime_plan.plan import prepare
from runtime_plan.verify import Judge
from scenec.compile import Compiled, compile_program
from tests.support.scene import library as scene_library
from tests.support.scene.drawn import drawn

PROGRAM = (Path(__file__).parents[2] / "data" / "scenes" / "facing_part.yaml").read_text()


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scene_library.library(tmp_path_factory.mktemp("library"), cubes=1)


def compiled_from(folder: Path, packages: Path, text: str = PROGRAM, diversity: float | None = None) -> Compiled:
    (folder / "program.yaml").write_text(text)
    return compile_program(folder / "program.yaml", packages, diversity=diversity)


def test_handle_and_spout_point_at_the_plate_in_every_draw(packages: Path, tmp_path: Path):
    compiled = compiled_from(tmp_path, packages, diversity=0.1)
    assert compiled.plan is not None
    samples = drawn(compiled.plan, 300)
    plate = samples.position_m[:, samples.names.index("plate"), :2]
    for name, heading_deg in (("mug", 90.0), ("second", 180.0)):
        column = samples.names.index(name)
        toward = plate - samples.position_m[:, column, :2]
        w, _, _, z = samples.quat_wxyz[:, column].T
        away = np.degrees(np.arctan2(*toward.T[::-1]) - 2.0 * np.arctan2(z, w)) - heading_deg
        assert np.abs((away + 180.0) % 360.0 - 180.0).max() <= 15.0
    assert list(Judge(prepare(compiled.plan)).violations(samples)) == []


def test_the_judge_refuses_a_mug_whose_front_points_at_the_plate(packages: Path, tmp_path: Path):
    compiled = compiled_from(tmp_path, packages, diversity=0.1)
    assert compiled.plan is not None
    samples = drawn(compiled.plan, 1)
    column = samples.names.index("mug")
    w, _, _, z = samples.quat_wxyz[0, column]
    half = np.arctan2(z, w) + np.pi / 4.0  # the front is where the handle was
    turned = samples.quat_wxyz.copy()
    turned[0, column] = [np.cos(half), 0.0, 0.0, np.sin(half)]
    rows = list(Judge(prepare(compiled.plan)).violations(replace(samples, quat_wxyz=turned)))
    assert ("relation", ["mug", "plate"]) in [(row["kind"], row["things"]) for row in rows]


@pytest.mark.parametrize(
    ("old", "new", "code", "text"),
    [
        ("mug.handle", "mug.handel", "scene/unknown-part", "did you mean `handle`?; it has handle, lid, part_0"),
        ("mug.handle", "mug.lid", "scene/part-without-direction", "over the origin"),
        ("[mug.handle, plate]", "[plate.rim, mug]", "scene/unknown-part", "its record has none"),
        ("[mug.handle, plate]", "[mug, plate.rim]", "scene/unknown-name", "no node or group `plate.rim`"),
        ("[mug.handle, plate]", "[cup.handle, plate]", "scene/unknown-name", "no node or group `cup.handle`"),
    ],
)
def test_parts_are_checked(old: str, new: str, code: str, text: str, packages: Path, tmp_path: Path):
    (diagnostic,) = compiled_from(tmp_path, packages, PROGRAM.replace(old, new)).report.diagnostics
    assert diagnostic.code == code
    assert text in diagnostic.headline
    assert diagnostic.where.line == 13


def test_a_part_of_a_thing_that_may_be_turned_over_has_no_direction(packages: Path, tmp_path: Path):
    over = "orientation: [[0.7071, 0.7071, 0, 0]]}}\n    second"
    text = PROGRAM.replace("surface: tabletop}}\n    second", f"surface: tabletop, {over}")
    (diagnostic,) = compiled_from(tmp_path, packages, text).report.diagnostics
    assert diagnostic.code == "scene/part-without-direction"
