"""Text of programs: includes, overlays, places that survive merging, bounds, all errors in one run."""

import json
import os
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenec.source.read import ReadResult, read_program
from source.include import load
from source.merge import merge, resolve_overlays
from source.parse import parse
from source.tree import Spans, plain
from tests.support.bad_inputs.scene import ANCHORS, BOX, HEAD, ON, SOUND

# The paper's listings, as they stand.
OVERLAY = """\
include: scene/pick_place.yaml
definition:
  scene_type: pick_place_ood
"""
FRAGMENT = """\
objects:
  - id: mug
    asset: {type: pool, candidates: [{id: mugs, assets: [mug_a, mug_b]}]}
    semantic_tags: [pickable]
layout:
  nodes:
    mug:
      object: mug
      placement: {type: surface, surface: tabletop, ranges: {x: [0.10, 0.20], y: [-0.10, 0.10]}}
"""


def read(folder: Path, root: Path | None = None, **files: str) -> ReadResult:
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.yaml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return read_program(folder / f"{next(iter(files)).replace('__', '/')}.yaml", root)


def merged(folder: Path, over: str, base: str) -> tuple[Any, list[str]]:
    """The overlay over its base as plain values, and the codes found."""
    (folder / "base.yaml").write_text(base)
    (folder / "over.yaml").write_text("include: base.yaml\n" + over)
    tree, found = load(folder / "over.yaml", folder.resolve())
    assert tree is not None
    rules = list(found)
    return plain(resolve_overlays(tree, rules)), [d.code for d in rules]


def test_the_papers_overlay_reads_with_a_base_that_has_its_anchors(tmp_path: Path):
    base = HEAD + ANCHORS + FRAGMENT
    found = read(tmp_path, program=OVERLAY, scene__pick_place=base)
    assert found.program is not None, found.diagnostics
    assert found.program.definition == {"scene_type": "pick_place_ood"}
    assert found.program.objects[0].semantic_tags == ("pickable",)


def test_the_papers_fragment_alone_names_the_anchor_that_it_lacks(tmp_path: Path):
    found = read(tmp_path, program=FRAGMENT)
    assert found.program is None
    assert [(d.code, d.where.line) for d in found.diagnostics] == [("scene/missing-anchor", 9)]
    assert "`tabletop`" in found.diagnostics[0].headline


def test_sections_under_definition_are_lifted_so_that_overlays_meet_them(tmp_path: Path):
    inside = "definition:\n  scene_type: kitchen\n" + "".join(f"  {line}\n" for line in SOUND.splitlines())
    over = "layout: {nodes: {a: {placement: {ranges: {x: [0, 0.1]}}}}}\n"
    found = read(tmp_path, program="include: base.yaml\n" + over, base=inside)
    assert found.program is not None, found.diagnostics
    assert found.program.layout.nodes["a"].placement.ranges.x == (0.0, 0.1)  # pyright: ignore
    assert found.program.definition == {"scene_type": "kitchen"}


@pytest.mark.parametrize(
    ("over", "base", "expected"),
    [
        ("l: [3]", "l: [1, 2]", [3]),
        ("l: {$append: [3]}", "l: [1, 2]", [1, 2, 3]),
        ("l: {$replace: [3], $append: [4]}", "l: [1, 2]", [3, 4]),
        ("l: {b: {n: 5}}", "l: [{id: a}, {id: b, n: 4, m: 1}]", [{"id": "a"}, {"id": "b", "n": 5, "m": 1}]),
        ("l: {a: {$delete: true}}", "l: [{id: a}, {id: b}]", [{"id": "b"}]),
        ("l: {one: {$delete: true}, $append: [two]}", "l: [one]", ["two"]),
        ("l: {$append: [3]}", "k: 1", [3]),
        ("l: {type: disc, r: 2}", "l: {type: box, size: 1}", {"type": "disc", "r": 2}),
        ("l: {type: box, n: 2}", "l: {type: box, size: 1}", {"type": "box", "size": 1, "n": 2}),
        ("l: 7", "l: {a: 1}", 7),
    ],
)
def test_rules_of_overlays(over: str, base: str, expected: Any, tmp_path: Path):
    values, found = merged(tmp_path, over, base)
    assert values["l"] == expected
    assert not found


def test_delete_takes_a_key_away_and_says_when_there_is_none(tmp_path: Path):
    assert merged(tmp_path, "a: {$delete: true}", "a: 1\nb: 2") == ({"b": 2}, [])
    for over in ("c: {$delete: true}", "b: {d: {$delete: true}}", "l: {x: {$delete: true}}", "$append: [1]"):
        assert merged(tmp_path, over, "b: {}\nl: [1]")[1] == ["scene/bad-overlay"]


def test_an_append_survives_two_overlays(tmp_path: Path):
    files = {"c": "k: 1", "b": "include: c.yaml\nl: {$append: [1]}", "a": "include: b.yaml\nl: {$append: [2]}"}
    for name, text in files.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    tree, found = load(tmp_path / "a.yaml", tmp_path.resolve())
    assert tree is not None
    assert plain(tree) == {"k": 1, "l": [1, 2]}
    assert not found


def test_every_value_keeps_its_own_file_line_and_column(tmp_path: Path):
    over = (
        "include: base.yaml\nclearance: 0.02\nobjects:\n  b:\n    scale: 2.0\n  $append:\n    - id: d\n      asset: x\n"
    )
    read_result = read(tmp_path, program=over, base=SOUND)
    assert read_result.spans.place(("clearance",)).model_dump(include={"file", "line", "column"}) == {
        "file": "program.yaml",
        "line": 2,
        "column": 12,
    }
    assert str(read_result.spans.place(("objects", 1, "scale"))) == "program.yaml:5:12"
    assert str(read_result.spans.place(("objects", 1, "id"))).startswith("base.yaml:3:")
    assert str(read_result.spans.place(("objects", 3, "id"))) == "program.yaml:7:11"
    assert str(read_result.spans.place(("layout", "nodes", "a"))) == "base.yaml:6:5"
    assert str(read_result.spans.place(("layout", "nodes", "a", "not_there"))) == "base.yaml:6:5"


def test_an_include_stands_at_any_node_and_is_relative_to_its_file(tmp_path: Path):
    read_result = read(
        tmp_path,
        program=HEAD + ANCHORS + "objects: {include: parts/objects.yaml}\nlayout: {include: parts/layout.yaml}\n",
        parts__objects=f"- {{include: one.yaml, scale: 2.0}}\n- {{id: b, asset: {BOX}}}\n",
        parts__one=f"id: a\nasset: {BOX}\n",
        parts__layout=f"nodes:\n  a: {{object: a, placement: {ON}}}\n  b: {{include: b.yaml}}\n",
        parts__b="object: b\nplacement: {type: surface, surface: tabletop}\n",
    )
    assert read_result.program is not None, read_result.diagnostics
    assert [(o.id, o.scale) for o in read_result.program.objects] == [("a", 2.0), ("b", 1.0)]
    assert str(read_result.spans.place(("layout", "nodes", "b", "object"))) == "parts/b.yaml:1:9"


def test_of_several_includes_the_later_lies_over_the_earlier(tmp_path: Path):
    found = read(tmp_path, program="include: [a.yaml, b.yaml]\n", a=SOUND + "clearance: 0.03\n", b="clearance: 0.04\n")
    assert found.program is not None, found.diagnostics
    assert found.program.clearance == 0.04


def test_the_root_folder_bounds_includes_also_through_links(tmp_path: Path):
    (tmp_path / "outside.yaml").write_text(SOUND)
    inside = tmp_path / "inside"
    assert read(inside, program="include: ../outside.yaml\n").diagnostics[0].code == "scene/path-escape"
    assert read(inside, tmp_path, program="include: ../outside.yaml\n").program is not None
    (inside / "link.yaml").symlink_to(tmp_path / "outside.yaml")
    assert read(inside, program="include: link.yaml\n").diagnostics[0].code == "scene/path-escape"


def test_all_errors_of_a_phase_are_told_in_one_run_in_the_order_of_the_text(tmp_path: Path):
    text = SOUND.replace("size_m: [1.2, 0.8, 0.05]", "size_m: [1.2, wide, -1]").replace("surface: auto", "surfce: auto")
    text = text.replace("object: b, ", "").replace("{type: box", "{type: bx", 2).replace("type: bx", "type: box", 1)
    found = [(d.code, d.where.line) for d in read(tmp_path, program=text).diagnostics]
    assert found == [
        ("scene/invalid-value", 1),
        ("scene/invalid-value", 1),
        ("scene/unknown-key", 2),
        ("scene/invalid-value", 3),
        ("scene/missing-key", 7),
    ]


@pytest.mark.parametrize(
    ("wrong", "meant"),
    [("layot", "layout"), ("clearence", "clearance"), ("keepouts", "keep_outs"), ("anchor", "anchors")],
)
def test_an_unknown_key_suggests_the_nearest(wrong: str, meant: str, tmp_path: Path):
    (found,) = read(tmp_path, program=SOUND + f"{wrong}: 1\n").diagnostics
    assert found.code == "scene/unknown-key"
    assert f"did you mean `{meant}`?" in found.headline


def test_keys_of_the_right_alternative_are_suggested(tmp_path: Path):
    text = SOUND.replace("size_m: [0.1, 0.1, 0.1]", "size_m: [0.1, 0.1, 0.1], mas_kg: 1", 1)
    (found,) = read(tmp_path, program=text).diagnostics
    assert found.headline == "`mas_kg` is not a key of `objects[0].asset`; did you mean `mass_kg`?"


def test_an_id_of_digits_is_a_text(tmp_path: Path):
    text = SOUND.replace("{id: a", "{id: 007").replace("object: a", "object: 007")
    found = read(tmp_path, program=text)
    assert found.program is not None, found.diagnostics
    assert found.program.objects[0].id == "007"


def test_numbers_must_be_finite(tmp_path: Path):
    for value in (".inf", ".nan"):
        (found,) = read(tmp_path, program=SOUND + f"clearance: {value}\n").diagnostics
        assert found.code == "scene/invalid-value"


@pytest.mark.parametrize(
    "text",
    [
        "a: &a [1, *a]\n",
        "x0: &x0 [1]\n" + "".join(f"x{i}: &x{i} [{', '.join([f'*x{i - 1}'] * 10)}]\n" for i in range(1, 12)),
        "[" * 5000,
        "{a: " * 3000,
        "- " * 3000,
    ],
    ids=["itself", "bomb", "brackets", "braces", "dashes"],
)
def test_hostile_text_is_turned_away_at_once(text: str, tmp_path: Path):
    start = time.process_time()
    found = read(tmp_path, program=text)
    assert found.program is None
    assert {d.code for d in found.diagnostics} <= {"scene/file-too-large", "scene/yaml-syntax"}
    assert time.process_time() - start < 5.0


def test_a_bomb_of_includes_is_bounded(tmp_path: Path):
    for i in range(30):
        (tmp_path / f"f{i}.yaml").write_text(f"a: {{include: f{i + 1}.yaml}}\nb: {{include: f{i + 1}.yaml}}\n")
    (tmp_path / "f30.yaml").write_text("x: 1\n")
    found = read_program(tmp_path / "f0.yaml")
    assert found.program is None
    assert "scene/file-too-large" in {d.code for d in found.diagnostics}


@pytest.mark.parametrize(
    "data", [b"\xff\xfe\x00", b"a: \x00", b"", b"- 1\n", b"a: 1\n---\nb: 2\n", b"!!python/object:os.system x\n"]
)
def test_odd_bytes_end_in_findings(data: bytes, tmp_path: Path):
    (tmp_path / "program.yaml").write_bytes(data)
    found = read_program(tmp_path / "program.yaml")
    assert all(d.code.startswith("scene/") for d in found.diagnostics)
    assert (found.program is None) == bool(found.diagnostics)


KEYS = st.text("abcdé", min_size=1, max_size=3)
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text("abc: -'\"é", max_size=6),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=12,
)


@given(VALUES)
def test_what_the_parser_reads_is_what_json_says(value: Any):
    """JSON is YAML 1.2: the tree of a JSON text holds the same values."""
    text = json.dumps({"value": value})
    assert plain(parse(text.encode(), "x.yaml").tree) == {"value": value}


@given(VALUES, VALUES)
def test_an_overlay_of_nothing_changes_nothing_and_one_of_everything_wins(base: Any, over: Any):
    found: list = []
    below = parse(json.dumps({"k": base}).encode(), "b.yaml").tree
    same = merge(below, parse(b"{}", "o.yaml").tree, found)
    assert plain(same) == {"k": base}
    above = parse(json.dumps({"k": over}).encode(), "o.yaml").tree
    if not isinstance(over, dict):
        assert plain(merge(below, above, found)) == {"k": over}
    assert plain(merge(below, below, [])) == {"k": base} or isinstance(base, list)
    assert str(Spans(same, "b.yaml").key(("k",))) == "b.yaml:1:2"


def test_a_colour_that_is_none_is_told_where_it_stands(tmp_path: Path):
    found = read(tmp_path, program=SOUND.replace("0.05]", "0.05], color: gren"))
    assert [(d.code, d.value, d.where.line) for d in found.diagnostics] == [("scene/invalid-value", "gren", 1)]
    assert "`green`" in found.diagnostics[0].headline
    for colour in ("green", '"#2a9d8f"', '"rgb(10, 20, 30)"'):
        assert read(tmp_path, program=SOUND.replace("0.05]", f"0.05], color: {colour}")).program is not None


def test_a_pipe_or_a_circle_of_links_is_a_missing_file_at_once(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe.yaml")
    (tmp_path / "loop.yaml").symlink_to("loop.yaml")
    for name in ("pipe.yaml", "loop.yaml"):
        assert [d.code for d in read_program(tmp_path / name).diagnostics] == ["scene/missing-file"]
        assert read(tmp_path, program=f"include: {name}\n").diagnostics[0].code == "scene/missing-file"


def test_a_directive_that_the_parser_does_not_know_is_a_finding(tmp_path: Path):
    found = read(tmp_path, program="%YAML 9.9\n---\n" + SOUND)
    assert [d.code for d in found.diagnostics] == ["scene/yaml-syntax"]
