"""A candidate or variant that alone causes a failure is named; the suggested edit was compiled."""

from pathlib import Path

from scenec.compile import compile_program
from scenec.explain.drop_choices import dropped_choices
from schemas.scene.compiled import CombinationVerdict, Verdict

PROGRAM = """\
background: {asset: {type: box, size_m: [0.6, 0.4, 0.04]}}
anchors: {top: {object: background, surface: auto}}
objects:
  - {id: tray, asset: {type: box, size_m: [0.3, 0.3, 0.02]}}
  - {id: cup, asset: {type: cylinder, radius_m: 0.04, height_m: 0.1}}
layout:
  nodes:
    tray: {object: tray, placement: {type: surface, surface: top}}
    cup: {object: cup, placement: {type: surface, surface: top}}
variants:
  assets:
    - {id: small, objects: {tray: {type: box, size_m: [0.2, 0.2, 0.02]}}}
    - {id: huge, objects: {tray: {type: box, size_m: [0.7, 0.3, 0.02]}}}
"""


def row(verdict: Verdict, **combination: str) -> CombinationVerdict:
    return CombinationVerdict(combination=combination, verdict=verdict)


def test_the_variant_that_cannot_fit_is_offered_first_and_works(tmp_path: Path):
    file = tmp_path / "p.yaml"
    file.write_text(PROGRAM)
    report = compile_program(file).report
    assert report.verdict == "infeasible"
    assert report.suggestions[0].edit == "drop huge of variants.assets"
    assert report.suggestions[0].verified
    file.write_text("".join(line for line in PROGRAM.splitlines(keepends=True) if "huge" not in line))
    assert compile_program(file).report.verdict == "compiled"


def test_a_candidate_is_named_by_its_object():
    rows = [
        row("compiled", **{"objects.bowl": "a", "background": "t"}),
        row("infeasible", **{"objects.bowl": "b", "background": "t"}),
    ]
    assert [edit.edit for edit in dropped_choices(rows)] == ["drop candidate b of bowl"]


def test_nothing_is_offered_where_no_single_choice_is_to_blame():
    bad = [row("infeasible", **{"objects.x": x}) for x in "ab"]
    assert dropped_choices([*bad, row("compiled", **{"objects.x": "c"})]) == ()
    assert dropped_choices([row("infeasible", **{"objects.x": "a"})]) == ()
    both = [row("budget_exhausted" if x == y == "a" else "compiled", x=x, y=y) for x in "ab" for y in "ab"]
    assert [edit.edit for edit in dropped_choices(both)] == ["drop candidate a of x", "drop candidate a of y"]
    assert (
        dropped_choices(
            [row("infeasible", **{"variants.assets": "as_written"}), row("compiled", **{"variants.assets": "v"})]
        )
        == ()
    )


def test_an_edit_is_offered_only_where_it_works_in_every_combination(tmp_path: Path):
    """A gap that leaves room beside the tray as written is too much beside the wide one."""
    text = PROGRAM.replace("[0.2, 0.2, 0.02]", "[0.39, 0.39, 0.02]").replace("[0.7, 0.3, 0.02]", "[0.35, 0.35, 0.02]")
    file = tmp_path / "p.yaml"
    file.write_text(text + "relations: [{left_of: [tray, cup], gap: 0.3}]\n")
    report = compile_program(file).report
    assert report.verdict == "infeasible"
    assert [edit.edit for edit in report.suggestions] == ["drop relations[0]"]
    for gap, verdict in ((0.219, "infeasible"), (0.119, "compiled")):
        file.write_text(text + f"relations: [{{left_of: [tray, cup], gap: {gap}}}]\n")
        assert compile_program(file).report.verdict == verdict
