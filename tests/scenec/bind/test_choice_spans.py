"""A finding caused by a choice shows the line of that choice; one of every combination shows none."""

from pathlib import Path

import pytest

from scenec.bind.asset_library import AssetLibrary
from scenec.bind.choice_spans import chosen_paths
from scenec.compile import compile_program
from schemas.scene.compiled import CompileReport
from schemas.scene.program import SceneProgram, SlotVariant
from tests.support.scene import library as scene_library

RACK = """\
background: {asset: {type: box, size_m: [0.8, 0.5, 0.04]}}
anchors: {top: {object: background, surface: auto}}
objects:
  - {id: a, asset: {type: box, size_m: [0.1, 0.1, 0.05]}}
  - {id: b, asset: {type: box, size_m: [0.1, 0.1, 0.05]}}
layout:
  nodes: {a: {object: a}, b: {object: b}}
  groups:
    rack: {type: slot, members: [a, b], surface: top, slots: [%s]}
variants:
  slots:
    - {id: wide, group: rack, assign: {a: l, b: r}}
    - {id: crowded, group: rack, assign: {a: l, b: m}}
"""
RACK %= "{id: l, x: -0.2, y: 0}, {id: m, x: -0.15, y: 0}, {id: r, x: 0.2, y: 0}"
POOL = """\
background: {asset: {type: box, size_m: [0.8, 0.14, 0.04]}}
anchors: {top: {object: background, surface: auto}}
objects:
  - {id: a, asset: {type: pool, candidates: [{id: p, assets: [cube]}, {id: q, assets: [bin]}]}}
  - {id: c, asset: {type: box, size_m: [0.05, 0.05, 0.05]}}
layout: {nodes: {a: {object: a, placement: {type: surface, surface: top}}}}
"""


@pytest.fixture
def library(tmp_path: Path) -> AssetLibrary:
    scene_library.cube(tmp_path / "library")
    scene_library.open_bin(tmp_path / "library", "bin")
    return AssetLibrary(tmp_path / "library")


def report(text: str, folder: Path, library: AssetLibrary | None = None) -> CompileReport:
    (folder / "p.yaml").write_text(text)
    return compile_program(folder / "p.yaml", library=library).report


def labels(report: CompileReport) -> list[tuple[int | None, str]]:
    return [(label.where.line, label.text) for label in report.diagnostics[-1].labels]


def test_a_slot_variant_that_cannot_be_is_shown(tmp_path: Path):
    assert labels(report(RACK, tmp_path))[-1] == (13, "variants.slots.rack: crowded")


def test_groups_whose_names_end_alike_are_told_apart():
    slots = [SlotVariant(id="crowded", group=group, assign={}) for group in ("rack", "left.rack")]
    program = SceneProgram.model_validate({"scene": "racks", "variants": {"slots": slots}})
    assert chosen_paths(program, {"variants.slots.left.rack": "crowded"}) == {
        "variants.slots.left.rack": ("variants", "slots", 1)
    }


def test_a_candidate_that_cannot_be_is_shown(tmp_path: Path, library: AssetLibrary):
    assert labels(report(POOL, tmp_path, library))[-1] == (4, "objects.a: bin")


def test_a_candidate_without_the_place_that_is_asked_for_is_shown(tmp_path: Path, library: AssetLibrary):
    text = POOL.replace("anchors: {", "anchors: {inside: {object: a, volume: auto}, ")
    text = text.replace("}}}}\n", "}}, c: {object: c, placement: {type: volume, volume: inside}}}}\n")
    assert labels(report(text, tmp_path, library)) == [(4, "a candidate of `a`")]


def test_what_every_combination_lacks_is_due_to_none(tmp_path: Path):
    other = "  backgrounds: [{id: bench, background: {asset: {type: box, size_m: [1.2, 0.4, 0.04]}}}]\n"
    text = RACK.partition("  slots:\n    -")[0] + other + "relations: [{left_of: [a, b]}, {left_of: [b, a]}]\n"
    found = report(text, tmp_path)
    assert found.diagnostics[-1].code == "scene/relation-cycle"
    assert "(with" not in found.diagnostics[-1].headline
    assert not [edit for edit in found.suggestions if "variants" in edit.edit]


def test_a_slip_in_the_split_is_told(tmp_path: Path, library: AssetLibrary):
    text = POOL.replace("[0.8, 0.14", "[0.8, 0.4") + "split: {train: [cube], eval: [bim, another_scenes_asset]}\n"
    found = report(text, tmp_path, library)
    assert found.verdict == "compiled"
    assert ["`bim`" in one.headline for one in found.diagnostics if one.code == "scene/unknown-name"] == [True]
