"""A program bound to geometry: places, headings, groups, relations, variants."""

from pathlib import Path

import numpy as np

from scenec.bind.asset_library import AssetLibrary
from scenec.bind.components import Lowered, lower
from scenec.source.read import read_program
from tests.support.bad_inputs.scene import GROUPED, ON_TRAY, SLOTS, SOUND, THREE, pool
from tests.support.scene import library as scene_library


def lowered(text: str, folder: Path, library: Path | None = None) -> Lowered:
    (folder / "program.yaml").write_text(text)
    read = read_program(folder / "program.yaml")
    assert read.program is not None, read.diagnostics
    return lower(read.program, AssetLibrary(library), read.spans)


def test_a_thing_keeps_its_place_footprint_and_path(tmp_path: Path):
    (problem,) = lowered(SOUND, tmp_path).problems
    a = problem.things[0]
    assert (a.name, a.parent, a.place.name, a.path) == ("a", "background", "top", ("layout", "nodes", "a"))
    (prism,) = a.body.resting_orientations[0].prisms
    assert sorted(map(tuple, np.round(prism.outline_m, 12))) == [(x, y) for x in (-0.05, 0.05) for y in (-0.05, 0.05)]
    assert (prism.low_m, prism.high_m) == (0.0, 0.1)
    assert np.allclose(a.place.origin_P_m, [0.0, 0.0, 0.05])


def test_what_stands_on_a_thing_has_it_as_parent(tmp_path: Path):
    (problem,) = lowered(ON_TRAY, tmp_path).problems
    assert [thing.parent for thing in problem.things] == ["background", "a", "background"]


def test_directions_become_vectors_by_where_the_viewer_stands(tmp_path: Path):
    relations = ["left_of: [a, b]", "right_of: [a, b]", "behind: [a, b]", "front_of: [a, b], viewpoint: left"]
    (problem,) = lowered(SOUND + "relations: [{" + "}, {".join(relations) + "}]\n", tmp_path).problems
    found = [(relation.things, relation.direction) for relation in problem.relations]
    assert found == [
        (("a", "b"), (1.0, 0.0)),
        (("b", "a"), (1.0, 0.0)),
        (("b", "a"), (0.0, 1.0)),
        (("a", "b"), (1.0, 0.0)),
    ]


def test_across_supports_that_turn_a_direction_needs_a_frame(tmp_path: Path):
    across = ON_TRAY + "relations: [{left_of: [b, c]%s}]\n"
    assert [d.code for d in lowered(across % "", tmp_path).diagnostics] == ["scene/frame-needed"]
    for frame, expected in (("a", "a"), ("inside", "a"), ("tabletop", "background"), ("world", "background")):
        (problem,) = lowered(across % f", frame: {frame}", tmp_path).problems
        assert problem.relations[0].frame == expected


def test_a_scatter_group_makes_copies_and_a_relation_to_it_means_all_of_them(tmp_path: Path):
    groups = "    many: {type: scatter, members: [a, b], surface: tabletop, count: 3}\n"
    groups += "    rest: {type: region, members: [c], surface: tabletop}\n"
    (problem,) = lowered(GROUPED + groups + "relations: [{left_of: [many, c]}]\n", tmp_path).problems
    names = [f"{node}-{i}" for node in "ab" for i in (1, 2, 3)]
    assert [thing.name for thing in problem.things] == [*names, "c"]
    assert [relation.things for relation in problem.relations] == [(name, "c") for name in names]


def test_an_assigned_slot_is_left_to_its_member(tmp_path: Path):
    (problem,) = lowered(GROUPED + SLOTS % (THREE, "a: l"), tmp_path).problems
    assert [[spot.name for spot in thing.domain.fixed_poses] for thing in problem.things] == [
        ["l"],
        ["m", "r"],
        ["m", "r"],
    ]


def test_degrees_and_full_turns(tmp_path: Path):
    head = "a: {object: a, placement: {type: surface, surface: tabletop"
    for ranges, expected in (("yaw_deg: [170, 190]", (170.0, 190.0)), ("yaw: [-4.2, 2.8]", (-180.0, 180.0))):
        text = SOUND.replace(head, f"{head}, ranges: {{{ranges}}}")
        (problem,) = lowered(text, tmp_path).problems
        assert np.allclose(np.degrees(problem.things[0].domain.yaw_rad), expected)


def test_the_order_of_sections_and_nodes_does_not_change_what_is_asked(tmp_path: Path):
    head, anchors, objects, *layout = SOUND.splitlines(keepends=True)
    turned = "".join([*layout[:2], *reversed(layout[2:]), objects, anchors, head])
    ways = [{t.name: t for t in lowered(text, tmp_path).problems[0].things} for text in (SOUND, turned)]
    assert list(ways[0]) == ["a", "b", "c"]
    assert list(ways[1]) == ["c", "b", "a"]
    for name, thing in ways[0].items():
        other = ways[1][name]
        assert (thing.parent, thing.place.name, thing.domain, thing.path) == (
            other.parent,
            other.place.name,
            other.domain,
            other.path,
        )
        assert np.array_equal(
            thing.body.resting_orientations[0].prisms[0].outline_m,
            other.body.resting_orientations[0].prisms[0].outline_m,
        )


def test_beyond_256_combinations_a_pool_is_as_large_as_all_its_candidates(tmp_path: Path):
    folder = tmp_path / "library"
    scene_library.cube(folder, "cube_0")
    scene_library.open_bin(folder, "bin")
    many = [f"twin_{i}" for i in range(1, 20)]
    for name in many:
        scene_library.cube(folder, name)
    pools = pool("bin", *many, text=pool("cube_0", *many), of="b")
    result = lowered(pools, tmp_path, folder)
    assert [part.union for part in result.components] == [("a", "b")]
    (problem,) = result.problems
    a, b, _ = problem.things
    assert (len(a.body.resting_orientations[0].prisms), len(b.body.resting_orientations[0].prisms)) == (20, 19 + 5)
    assert np.isclose(b.body.resting_orientations[0].height_m, 0.08)
