"""Texts of findings about keys and values: the words of the language, the alternatives, no word of Python."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenec.source.read import read_program
from schemas.diagnostics import Diagnostic
from tests.support.bad_inputs.scene import GROUPED, SOUND

PYTHON = ("tuple", "dict", "instance", "None", "bool", "unable to parse", "class", "str ", "float")


def findings(folder: Path, text: str) -> tuple[Diagnostic, ...]:
    (folder / "program.yaml").write_text(text)
    return read_program(folder / "program.yaml").diagnostics


@pytest.mark.parametrize(
    ("text", "headline"),
    [
        (SOUND + "relations: [{left_of: a}]\n", "`relations[0].left_of` should be a list"),
        (SOUND + "relations: {left_of: [a, b]}\n", "`relations` should be a list"),
        (SOUND + "variants: {lighting: {id: x}}\n", "`variants.lighting` should be a list"),
        (SOUND + "split: {train: mug}\n", "`split.train` should be a list"),
        (SOUND + "relations: [{near: [a, b], distance: far}]\n",
         "`relations[0].distance` should be a number or a list"),
        (SOUND + "clearance: -1\n", "`clearance` should be at least 0"),
        (SOUND + "clearance: .inf\n", "`clearance` should be a finite number"),
        (SOUND + "relations: [{left_of: [a, b], viewpoint: bak}]\n",
         "`relations[0].viewpoint` should be `front`, `back`, `left` or `right`; did you mean `back`?"),
        (SOUND.replace("[0.1, 0.1, 0.1]", "0.1", 1), "`objects[0].asset.size_m` should be a list"),
        (SOUND.replace("{object: a,", "{object: a, joints: [1],"), "`layout.nodes.a.joints` should be a mapping"),
        (SOUND.replace("surface: tabletop}", "surface: tabletop, orientation: flat}", 1),
         "`layout.nodes.a.placement.orientation` should be `upright`, `stable` or a list"),
        (GROUPED + "    g: {type: region, members: [], surface: tabletop}\n",
         "`layout.groups.g.members` needs at least 1 entry, and has 0"),
        (GROUPED + "    g: {type: region, members: a, surface: tabletop}\n",
         "`layout.groups.g.members` should be a list"),
        (GROUPED + "    g: {type: scatter, members: [a, b, c], surface: tabletop, count: 1.5}\n",
         "`layout.groups.g.count` should be a whole number"),
        (GROUPED + "    g: {type: heap, members: [a, b, c], surface: tabletop}\n",
         "`layout.groups.g` has an unknown type; it takes region, scatter, volume, slot, stack, grid"),
        ("3\n", "the program should be a mapping"),
    ],
)  # fmt: skip
def test_values_are_named_in_the_words_of_the_language(text: str, headline: str, tmp_path: Path):
    (diagnostic,) = findings(tmp_path, text)
    assert diagnostic.code in ("scene/invalid-value", "scene/missing-key")
    assert diagnostic.headline == headline
    assert not [word for word in PYTHON if word in diagnostic.headline]


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("relations: [{on: [a, b]}]\n", "what a thing stands on or in is its `placement`; the words are left_of,"),
        ("relations: [{lef_of: [a, b]}]\n", "`lef_of` is not a key of `relations[0]`; did you mean `left_of`?"),
        ("lights: []\n", "`lights` is not a key of the program; did you mean `variants.lighting`?"),
        ("camera: []\n", "did you mean `cameras`?"),
        ("grops: {}\n", "did you mean `layout.groups`?"),
    ],
)
def test_unknown_keys_name_what_was_meant_and_no_list_of_all_keys(text: str, part: str, tmp_path: Path):
    (diagnostic,) = findings(tmp_path, SOUND + text)
    assert diagnostic.code == "scene/unknown-key"
    assert part in diagnostic.headline
    assert "tolerance" not in diagnostic.headline


def test_reach_of_a_robot_and_ranges_of_joints_are_refused_by_name(tmp_path: Path):
    (diagnostic,) = findings(tmp_path, SOUND + "reach: {base: [0, 0, 0], radius: 0.8, robot: panda}\n")
    assert diagnostic.code == "scene/robot-reach"
    (diagnostic,) = findings(tmp_path, SOUND.replace("{object: a,", "{object: a, joints: {door: [0, 1]},"))
    assert diagnostic.code == "scene/joint-state-range"
