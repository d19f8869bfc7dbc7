"""Tiny programs, one for each construct of the language: they read, fit the schema, and give the right problem."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from ruamel.yaml import YAML

from scenec.bind.asset_library import AssetLibrary
from scenec.bind.components import lower
from scenec.compile import compile_program
from scenec.ir.problem import Problem
from scenec.source.language import editor_schema
from scenec.source.read import read_program
from tests.support.scene import library as scene_library

SCENES = sorted((Path(__file__).parents[2] / "data" / "scenes").glob("*.yaml"))
EXAMPLES = sorted((Path(__file__).parents[3] / "examples" / "scenes").glob("*.yaml"))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(scene_library.library(tmp_path_factory.mktemp("library"), cubes=1))


@pytest.fixture(scope="module")
def problems(library: AssetLibrary) -> dict[str, tuple[Problem, ...]]:
    """The problems of each program by its file's stem; none has a finding."""
    problems_of = {}
    for path in SCENES:
        read = read_program(path)
        assert read.program is not None, read.diagnostics
        lowered = lower(read.program, library, read.spans)
        assert not read.diagnostics + lowered.diagnostics
        problems_of[path.stem] = lowered.problems
    return problems_of


@pytest.mark.parametrize("path", SCENES + EXAMPLES, ids=lambda path: path.stem)
def test_programs_fit_the_schema_for_editors(path: Path):
    jsonschema.validate(YAML(typ="safe", pure=True).load(path), editor_schema())


@pytest.mark.parametrize("text", ["layot: {}", "objects: [{id: a, asset: {type: bx}}]", "clearance: -1", "scene: [a]"])
def test_the_schema_for_editors_turns_away_what_the_compiler_does(text: str):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(YAML(typ="safe", pure=True).load(text), editor_schema())


def test_the_schema_is_itself_a_schema():
    jsonschema.Draft202012Validator.check_schema(editor_schema())
    assert json.dumps(editor_schema(), sort_keys=True)


def test_overlay(problems: dict[str, tuple[Problem, ...]]):
    (problem,) = problems["overlay"]
    cup, block = problem.things
    assert problem.scene == "overlay"
    assert cup.domain.x_m == (0.2, 0.3)
    assert np.isclose(cup.body.resting_orientations[0].height_m, 0.12)
    assert block.name == "block"


def test_primitives_stand_on_each_of_their_sides(problems: dict[str, tuple[Problem, ...]]):
    box, can, ball = problems["primitives"][0].things
    assert np.allclose(sorted(stance.height_m for stance in box.body.resting_orientations), [0.04, 0.06, 0.1])
    assert np.allclose([stance.height_m for stance in can.body.resting_orientations], [0.12, 0.06], atol=1e-5)
    assert np.isclose(ball.body.resting_orientations[0].height_m, 0.08)
    for thing in (box, can, ball):
        for stance in thing.body.resting_orientations:
            assert min(prism.low_m for prism in stance.prisms) == 0.0


def test_surface_of_a_package_and_drawn(problems: dict[str, tuple[Problem, ...]]):
    on_ring, cube = problems["surface"][0].things
    assert np.isclose(on_ring.place.polygon.area, 0.8 * 0.6 - 0.04)
    assert on_ring.place.height_m == 0.5
    assert np.allclose(np.degrees(on_ring.domain.yaw_rad), (80, 100))
    assert cube.parent == "bin"
    walls = cube.place.above
    assert len(walls) == 4
    assert all(np.isclose(wall.low_m, 0.0) and np.isclose(wall.high_m, 0.07) for wall in walls)


def test_volume_is_as_hollow_as_its_owner(problems: dict[str, tuple[Problem, ...]]):
    _, cube = problems["volume"][0].things
    assert np.isclose(cube.place.height_m, 0.07)
    assert all(np.isclose(layer.area, 0.18 * 0.13) for _, _, layer in cube.place.layers)


def test_discrete_poses_stand_and_keep_their_heading(problems: dict[str, tuple[Problem, ...]]):
    (box,) = problems["discrete"][0].things
    first, second = box.domain.fixed_poses
    assert np.isclose(first.yaw_rad, np.pi / 2)
    assert np.isclose(first.z_m, 0.0)
    # (0.5, 0.5, 0.5, 0.5) turns x to y, y to z, z to x: what was 6 cm wide is now high.
    assert np.isclose(box.body.resting_orientations[second.stance].height_m, 0.06)
    assert np.isclose(second.z_m, 0.03)


def test_groups_place_their_members(problems: dict[str, tuple[Problem, ...]]):
    assert {(t.group, t.domain.x_m) for t in problems["region"][0].things} == {("row", (-0.2, 0.2))}
    beans = [t.name for t in problems["scatter"][0].things if t.group == "beans"]
    assert beans == [f"bean-{i}" for i in range(1, 9)]
    assert [r.things for r in problems["scatter"][0].relations] == [(bean, "bowl") for bean in beans]
    assert [t.parent for t in problems["volume_group"][0].things] == ["background", "bin", "bin"]


def test_slots_and_their_variant(problems: dict[str, tuple[Problem, ...]]):
    as_written, swapped = problems["slot"]
    assert as_written.combination == {"variants.slots.rack": "as_written"}
    assert [[s.name for s in t.domain.fixed_poses] for t in as_written.things] == [["left"], ["right"]]
    assert [[s.name for s in t.domain.fixed_poses] for t in swapped.things] == [["right"], ["left"]]


def test_relations(problems: dict[str, tuple[Problem, ...]]):
    relations = problems["relations"][0].relations
    assert [r.word for r in relations] == [
        *("left_of", "right_of", "front_of", "behind", "near", "far_from", "aligned", "facing", "between")
    ]
    assert [r.things for r in relations[:4]] == [("a", "b"), ("b", "c"), ("a", "d"), ("b", "d")]
    assert [r.path for r in relations] == [("relations", i) for i in range(9)]
    assert np.isclose(relations[7].tolerance, np.radians(20))


def test_keep_outs_and_reach(problems: dict[str, tuple[Problem, ...]]):
    (problem,) = problems["limits"]
    assert [np.round(k.polygon.area, 9) for k in problem.keep_outs] == [0.6 * 0.8, 0.045]
    assert [k.height_m for k in problem.keep_outs] == [np.inf, 0.3]
    assert problem.reach is not None
    assert problem.reach.members == ("a",)


def test_every_combination_of_variants_is_a_problem(problems: dict[str, tuple[Problem, ...]]):
    found = problems["variants"]
    assert len({tuple(sorted(p.combination.items())) for p in found}) == len(found) == 2 * 2 * 2
    turned = next(p for p in found if p.combination["variants.backgrounds"] == "turned")
    assert np.allclose(turned.X_WB[:2, 0], [np.cos(np.pi / 6), np.sin(np.pi / 6)])
    assert np.allclose(turned.X_WB[:3, 3], [0, 0, 0.7])
    flat = next(p for p in found if p.combination["variants.assets"] == "flat")
    assert np.isclose(flat.things[1].body.resting_orientations[0].height_m, 0.01)


def test_the_programs_of_the_reference_page_are_sound(tmp_path: Path, library: AssetLibrary):
    page = (Path(__file__).parents[3] / "docs" / "reference" / "scene-language.md").read_text()
    whole, anchor, joints, overlay = (part.split("```")[0] for part in page.split("```yaml\n")[1:])
    base = whole.replace("anchors:\n", anchor)
    base = base.replace("  - {id: cup", "  - {id: old, asset: {type: sphere, radius_m: 0.02}}\n  - {id: cup")
    old = "    old: {object: old, placement: {type: surface, surface: half}}\n"
    (tmp_path / "base.yaml").write_text(base.replace("relations:\n", old + "relations:\n"))
    (tmp_path / "overlay.yaml").write_text(overlay)
    (tmp_path / "joints.yaml").write_text(joints)
    nodes_of = {"base": ["tray", "cup", "spare", "old"], "overlay": ["tray", "cup", "spare"]}
    for name, nodes in (nodes_of | {"joints": ["cabinet", "oven", "sock"]}).items():
        read = read_program(tmp_path / f"{name}.yaml")
        assert read.program is not None, read.diagnostics
        lowered = lower(read.program, library, read.spans)
        assert [thing.name for thing in lowered.problems[0].things] == nodes
        assert [d.code for d in read.diagnostics] == (["scene/unplaced-object"] if name == "overlay" else [])


def test_a_written_pose_keeps_its_orientation(tmp_path: Path):
    poses = "poses: [{x: 5.0, y: 0.0}, {x: 0.2, y: 0.1, quat_wxyz: [0.5, 0.5, 0.5, 0.5]}]"
    text = (Path(__file__).parents[2] / "data" / "scenes" / "discrete.yaml").read_text()
    (tmp_path / "program.yaml").write_text(text[: text.index("poses:")] + poses + "\n")
    compiled = compile_program(tmp_path / "program.yaml")
    (box,) = compiled.scenes[0].objects
    assert np.allclose(np.abs(box.quat_wxyz), 0.5)
    assert np.isclose(min(prism.low_m for prism in box.prisms), 0.05)
