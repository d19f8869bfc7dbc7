"""Angles in degrees and sizes in centimetres, written where radians and metres are read: reported, and nothing else."""

from pathlib import Path

import pytest

from scenec.source.read import ReadResult, read_program
from tests.support.bad_inputs.scene import BOX, GROUPED, HEAD, ON, SLOTS, SOUND, THREE, placed

ROOT = Path(__file__).parents[3]
PROGRAMS = sorted([*(ROOT / "tests/data/scenes").glob("*.yaml"), *(ROOT / "examples/scenes").glob("*.yaml")])
CODES = ("scene/degrees-suspected", "scene/size-implausible")
POSES = SOUND.replace(
    f"a, placement: {ON}", "a, placement: {type: discrete, surface: tabletop, poses: [{x: 0, y: 0, %s}]}"
)
REGION = "    row: {type: region, members: [a, b, c], surface: tabletop, ranges: {%s}}\n"


def read(folder: Path, text: str) -> ReadResult:
    (folder / "program.yaml").write_text(text)
    return read_program(folder / "program.yaml")


def sized(asset: str, more: str = "") -> str:
    """The sound program with another asset, and more keys, for its first object."""
    return SOUND.replace(f"id: a, asset: {BOX}", f"id: a, asset: {asset}{more}")


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_sound_programs_are_not_doubted(path: Path):
    assert not [d for d in read_program(path).diagnostics if d.code in CODES]


WRONG_ANGLES = {
    "range": (placed(a="{yaw: [-90, 90]}"), "yaw_deg: [-90, 90]", -90.0),
    "small range": (placed(a="{yaw: [-15, 15]}"), "yaw_deg: [-15, 15]", -15.0),
    "one end": (placed(a="{yaw: [0, 7.5]}"), "yaw_deg: [0, 7.5]", 7.5),
    "background": (HEAD.replace("}}", "}, yaw: 30}") + SOUND.removeprefix(HEAD), "yaw_deg: 30", 30.0),
    "pose": (POSES % "yaw: 45", "yaw_deg: 45", 45.0),
    "slot": (GROUPED + SLOTS % (THREE.replace("y: 0}", "y: 0, yaw: -90}", 1), ""), "yaw_deg: -90", -90.0),
    "group": (GROUPED + REGION % "yaw: [0, 360]", "yaw_deg: [0, 360]", 360.0),
    "tolerance": (SOUND + "relations: [{facing: [a, b], tolerance: 10}]\n", "tolerance_deg: 10", 10.0),
    "lighting": (SOUND + "variants: {lighting: [{id: l, rotation: [0, 360]}]}\n", "rotation: [0, 6.283]", 360.0),
    "other background": (
        SOUND + "variants: {backgrounds: [{id: v, background: {asset: {type: sphere, radius_m: 1}, yaw: 90}}]}\n",
        "yaw_deg: 90",
        90.0,
    ),
}


@pytest.mark.parametrize("name", WRONG_ANGLES)
def test_more_than_a_full_turn_is_an_error_that_names_the_key_for_degrees(name: str, tmp_path: Path):
    text, meant, value = WRONG_ANGLES[name]
    found = read(tmp_path, text)
    assert found.program is None
    assert [(d.code, d.severity, d.value, d.unit) for d in found.diagnostics] == [(CODES[0], "error", value, "rad")]
    assert found.diagnostics[0].headline.endswith(f"; did you mean `{meant}`?")


@pytest.mark.parametrize(
    "text",
    [
        placed(a="{yaw: [0, 5]}"),
        placed(a="{yaw: [-6, 6]}"),
        POSES % "yaw: 4",
        SOUND + "relations: [{facing: [a, b], tolerance: 3}]\n",
    ],
)
def test_whole_radians_beyond_half_a_turn_are_a_warning(text: str, tmp_path: Path):
    found = read(tmp_path, text)
    assert found.program is not None
    assert [(d.code, d.severity) for d in found.diagnostics] == [(CODES[0], "warning")]
    assert "_deg: " in found.diagnostics[0].headline


@pytest.mark.parametrize(
    "yaw",
    [
        *("[0, 6.283185307179586]", "[-3.1416, 3.1416]", "[0, 6.2832]", "[0, 6.29]", "[0, 6.3]", "[-6.3, 0]"),
        *("[-4.2, 2.8]", "[4, 5.5]", "[-3, 3]", "[0, 1]", "[3.0, 3.3]", "[4.71, 4.71]"),
    ],
)
def test_radians_are_not_doubted(yaw: str, tmp_path: Path):
    for key in (f"yaw: {yaw}", "yaw_deg: [-90, 90]", "yaw_deg: [170, 190]"):
        assert read(tmp_path, placed(a=f"{{{key}}}")).diagnostics == ()


def test_the_tolerance_of_other_relations_is_a_length(tmp_path: Path):
    for relation in ("{aligned: [a, b], tolerance: 7}", "{between: [a, b, c], tolerance: 7}"):
        assert read(tmp_path, SOUND + f"relations: [{relation}]\n").diagnostics == ()


def test_the_place_is_that_of_the_value_also_in_an_included_file(tmp_path: Path):
    (tmp_path / "base.yaml").write_text(SOUND)
    over = "include: base.yaml\nlayout:\n  nodes:\n    a: {placement: {ranges: {yaw: [-90, 90]}}}\n"
    found = read(tmp_path, over + "objects:\n  b: {asset: {size_m: [21, 15, 3]}}\n")
    assert [(d.code, str(d.where)) for d in found.diagnostics] == [
        (CODES[0], "program.yaml:4:30"),
        (CODES[1], "program.yaml:6:15"),
    ]
    (tmp_path / "base.yaml").write_text(HEAD.replace("}}", "}, yaw: 30}") + SOUND.removeprefix(HEAD))
    found = read(tmp_path, "include: base.yaml\n")
    assert [str(d.where) for d in found.diagnostics] == [f"base.yaml:1:{HEAD.index('}}') + 9}"]


WRONG_SIZES = {
    "box": (sized("{type: box, size_m: [21, 15, 3]}"), "centimetres? Then write `size_m: [0.21, 0.15, 0.03]`", 21.0),
    "box in millimetres": (
        sized("{type: box, size_m: [210, 150, 0.8]}"),
        "millimetres? Then write `size_m: [0.21",
        210.0,
    ),
    "cylinder": (
        sized("{type: cylinder, radius_m: 4, height_m: 10}"),
        "centimetres? Then write `radius_m: 0.04, height_m: 0.1`",
        10.0,
    ),
    "ball": (sized("{type: sphere, radius_m: 4}"), "centimetres? Then write `radius_m: 0.04`", 8.0),
    "scaled up": (sized("{type: box, size_m: [21, 15, 3]}", ", scale: 2"), "centimetres?", 21.0),
    "table": (
        SOUND.replace("[1.2, 0.8, 0.05]", "[120, 80, 5]"),
        "centimetres? Then write `size_m: [1.2, 0.8, 0.05]`",
        120.0,
    ),
    "shelf": (sized("{type: box, size_m: [90, 40, 200]}", ", role: fixture"), "centimetres?", 200.0),
    "variant": (
        SOUND + "variants: {assets: [{id: v, objects: {b: {type: box, size_m: [8, 6, 12]}}}]}\n",
        "centimetres?",
        12.0,
    ),
}


@pytest.mark.parametrize("name", WRONG_SIZES)
def test_sizes_that_can_hardly_be_metres_ask_for_the_unit(name: str, tmp_path: Path):
    text, asked, value = WRONG_SIZES[name]
    found = read(tmp_path, text)
    assert found.program is not None
    assert [(d.code, d.severity, d.value, d.unit) for d in found.diagnostics] == [(CODES[1], "warning", value, "m")]
    assert asked in found.diagnostics[0].headline


@pytest.mark.parametrize(
    "text",
    [
        sized("{type: box, size_m: [2.4, 1.2, 0.02]}"),
        sized("{type: box, size_m: [21, 15, 3]}", ", scale: 0.01"),
        sized("{type: box, size_m: [0.1, 0.1, 0.1]}", ", scale: 40"),
        sized("{type: box, size_m: [12, 0.2, 2.5]}", ", role: support"),
        SOUND.replace("[1.2, 0.8, 0.05]", "[10, 8, 0.05]"),
        SOUND.replace("[1.2, 0.8, 0.05]", "[100, 100, 0.1]"),
        SOUND.replace("[1.2, 0.8, 0.05]", "[4, 3, 1]"),
    ],
)
def test_sizes_in_metres_are_not_doubted(text: str, tmp_path: Path):
    assert read(tmp_path, text).diagnostics == ()
