"""Every small program compiles and its plan draws valid scenes; what cannot hold is named, with a number that works."""

from __future__ import annotations

from pathlib import Path

import pytest
from ruamel.yaml import YAML

from runtime_plan import prepare, sample
from runtime_plan.verify import Judge
from scenec.compile import compile_program
from schemas.scene.relations import RELATION_KINDS

SCENES = Path(__file__).parents[2] / "data" / "scenes"
KINDS = [kind for kind in RELATION_KINDS if (SCENES / f"{kind}.yaml").exists()]
TABLE = "background: {asset: {type: box, size_m: [0.9, 0.6, 0.05]}}\nanchors: {top: {object: background}}\n"
BLOCKS = """\
objects: [{id: block, asset: {type: box, size_m: [0.06, 0.05, 0.08]}}]
layout:
  nodes:
    a: {object: block, placement: {type: surface, surface: top}}
    b: {object: block, placement: {type: surface, surface: top}}
    c: {object: block, placement: {type: surface, surface: top}}
    d: {object: block, placement: {type: surface, surface: top}}
"""
CRATE = """\
background: {asset: {type: box, size_m: [0.9, 0.6, 0.05]}}
anchors:
  top: {object: background}
  lid: {object: crate}
  inside: {object: background, volume: {outline: SQUARE, z: 0.05, height: 0.3}}
objects:
  - {id: crate, asset: {type: box, size_m: [0.3, 0.2, 0.12]}}
  - {id: block, asset: {type: box, size_m: [0.06, 0.05, 0.08]}}
layout:
  nodes:
    crate: {object: crate, placement: {type: surface, surface: top, ranges: {x: [-0.3, -0.2]}}}
    a: {object: block, placement: {type: surface, surface: lid}}
    b: {object: block, placement: {type: surface, surface: top, ranges: {x: [-0.4, 0.05]}}}
    c: {object: block, placement: {type: volume, volume: inside}}
    d: {object: block, placement: {type: volume, volume: inside}}
"""
SQUARE = "[[0.1, -0.1], [0.3, -0.1], [0.3, 0.1], [0.1, 0.1]]"
# A relation that cannot hold, and the start of a suggestion that was compiled.
IMPOSSIBLE = {
    "{above: [a, b], gap: 0.2}": "drop relations[0]",
    "{below: [a, b]}": "drop relations[0]",
    "{surrounding: [a, b, c, d], least_angle_deg: 125}": "set least_angle_deg of relations[0] to 1",
    "{surrounding: [a, b, c, d], least_angle: 2.2}": "set least_angle of relations[0] to ",
    "{surrounding: [a, b, c, d], evenly: true, distance: [1.2, 1.3]}": "set distance[0] of relations[0] to ",
    "{in_line: [a, b, c, d], spacing: 0.3}": "set tolerance of relations[0] to ",
    "{in_line: [a, b, c, d], axis: y, spacing: 0.25}": "set spacing of relations[0] to ",
}


def written(tmp_path: Path, relations: str, text: str = TABLE + BLOCKS) -> Path:
    """A program file with these relations."""
    file = tmp_path / "program.yaml"
    file.write_text(f"{text}relations: {relations}\n")
    return file


@pytest.mark.parametrize("kind", KINDS)
def test_the_plan_of_the_small_program_draws_valid_scenes_that_differ(kind: str) -> None:
    compiled = compile_program(SCENES / f"{kind}.yaml", diversity=0.2)
    assert compiled.report.verdict == "compiled", compiled.report.diagnostics
    assert compiled.plan is not None
    plan = prepare(compiled.plan)
    drawn = sample(plan, 1000, 0)
    assert list(Judge(plan).violations(drawn)) == []
    assert (drawn.position_m[:, :, :2].std(axis=0) > 0.02).all()


@pytest.mark.parametrize(
    "relation",
    [
        "{above: [a, b], gap: 0.03}",
        "{above: [a, c]}",
        "{below: [c, d]}",
        "{above: [c, d], overlap: true}",
        "{above: [c, crate]}",
    ],
)
def test_heights_on_a_crate_and_in_a_pile_hold_in_every_draw(relation: str, tmp_path: Path) -> None:
    file = written(tmp_path, f"[{relation}]", CRATE.replace("SQUARE", SQUARE))
    compiled = compile_program(file, diversity=0.1)
    if relation == "{above: [c, crate]}":  # one block on another is lower than the crate
        assert compiled.report.verdict in ("infeasible", "budget_exhausted")
        return
    assert compiled.report.verdict == "compiled", compiled.report.diagnostics
    assert compiled.plan is not None
    plan = prepare(compiled.plan)
    assert list(Judge(plan).violations(sample(plan, 1000, 0))) == []


IN_RADIANS = "{surrounding: [a, b, c, d], least_angle: 2.2}"  # as in degrees, and as long to explain


@pytest.mark.parametrize(
    "relation", [pytest.param(r, marks=pytest.mark.long if r == IN_RADIANS else ()) for r in IMPOSSIBLE]
)
def test_an_impossible_relation_is_named_with_its_line_and_a_weaker_one_compiles(relation: str, tmp_path: Path) -> None:
    """Explained once, as that takes long: the line, a suggestion, and that every suggested number works."""
    file = written(tmp_path, f"\n  - {relation}")
    report = compile_program(file).report
    assert report.verdict == "infeasible", report.diagnostics
    line = file.read_text().splitlines().index(f"  - {relation}") + 1
    assert line in [place.line for place in report.conflict]
    edits = [suggestion.edit for suggestion in report.suggestions]
    assert any(edit.startswith(IMPOSSIBLE[relation]) for edit in edits), edits
    for edit in (e for e in edits if e.startswith("set ")):
        key, value = edit.removeprefix("set ").split(" of relations[0] to ")
        compiled = compile_program(written(tmp_path, f"[{with_number(relation, key, value)}]"))
        assert compiled.report.verdict == "compiled", edit


def with_number(relation: str, key: str, value: str) -> str:
    """The written relation with another number in a key, or in one end of a range."""
    tree = YAML(typ="safe").load(relation)
    name, _, end = key.rstrip("]").partition("[")
    if end:
        tree[name][int(end)] = float(value)
    else:
        tree[name] = float(value)
    return str(tree).replace("True", "true")


@pytest.mark.parametrize(
    ("relation", "code"),
    [
        ("{surrounding: [a, b, c]}", "scene/missing-key"),
        ("{surrounding: [a, b, c], evenly: true, least_angle_deg: 20}", "scene/given-twice"),
        ("{surrounding: [a, b, c], least_angle: 0.5, least_angle_deg: 20}", "scene/given-twice"),
        ("{surrounding: [a, b, c], evenly: true, tolerance: 0.5, tolerance_deg: 20}", "scene/given-twice"),
        ("{surrounding: [a, b, c], least_angle_deg: 20, tolerance_deg: 20}", "scene/option-without-effect"),
        ("{surrounding: [a, b, c], least_angle: 30}", "scene/degrees-suspected"),
        ("{surrounding: [a, b, c], evenly: true, distance: [0.3, 0.1]}", "scene/range-reversed"),
        ("{surrounding: [a, b], evenly: true}", "scene/invalid-value"),
        ("{above: [a, b], distance: 0.3}", "scene/option-without-effect"),
        ("{in_line: [a, b], gap: 0.3}", "scene/option-without-effect"),
        ("{in_line: [a]}", "scene/invalid-value"),
    ],
)
def test_a_wrong_key_or_number_is_a_finding(relation: str, code: str, tmp_path: Path) -> None:
    report = compile_program(written(tmp_path, f"[{relation}]")).report
    assert code in [diagnostic.code for diagnostic in report.diagnostics]
