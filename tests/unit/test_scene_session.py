"""A warm session gives the verdicts of a cold compile, and leaves what an edit does not concern where it was."""

from pathlib import Path

from cli.scene_edit import saved
from scenec.compile import Compiled, compile_program
from scenec.session import Session

PROGRAM = """\
background: {{asset: {{type: box, size_m: [1.0, 0.6, 0.04]}}}}
anchors: {{top: {{object: background, surface: auto}}}}
objects:
  - {{id: book, asset: {{type: box, size_m: {book}}}}}
  - {{id: cup, asset: {{type: cylinder, radius_m: 0.04, height_m: 0.1}}}}
  - {{id: pen, asset: {{type: box, size_m: [0.14, 0.01, 0.01]}}}}
layout:
  nodes:
    book: {{object: book, placement: {{type: surface, surface: top}}}}
    cup: {{object: cup, placement: {{type: surface, surface: top}}}}
    pen: {{object: pen, placement: {{type: surface, surface: top}}}}
relations: [{{left_of: [book, cup], gap: {gap}}}]
"""


def at(compiled: Compiled) -> dict[str, tuple[float, float, float]]:
    return {item.id: item.position_m for item in compiled.scenes[0].objects}


def test_an_edit_moves_no_more_than_it_must_and_the_verdict_is_that_of_a_cold_compile(tmp_path: Path):
    file, session = tmp_path / "p.yaml", Session()
    file.write_text(PROGRAM.format(book="[0.2, 0.15, 0.03]", gap=0.02))
    first = session.compile(file)
    assert first.scenes == compile_program(file).scenes
    for book, gap, verdict in (
        ("[0.2, 0.15, 0.04]", 0.02, "compiled"),
        ("[0.2, 0.15, 0.04]", 2.0, "infeasible"),
        ("[0.2, 0.15, 0.04", 0.02, "invalid_program"),
        ("[0.2, 0.15, 0.05]", 0.02, "compiled"),
    ):
        file.write_text(PROGRAM.format(book=book, gap=gap))
        cold, warm = compile_program(file), session.compile(file)
        assert warm.report.verdict == cold.report.verdict == verdict
        assert warm.report.diagnostics == cold.report.diagnostics
    last = session.last
    assert last is not None
    assert at(last) == at(first), "a higher book stands where the lower one stood"
    assert last.scenes[0].objects[0].prisms[0].high_m == 0.04 + 0.05


def test_a_saved_file_is_compiled_again(tmp_path: Path):
    file = tmp_path / "p.yaml"
    file.write_text(PROGRAM.format(book="[0.2, 0.15, 0.03]", gap=0.02))
    edits = saved(Session(), file, tmp_path, wait_s=0.0)
    assert next(edits).report.verdict == "compiled"
    file.write_text(PROGRAM.format(book="[0.2, 0.15, 0.03]", gap=3.25))
    assert next(edits).report.verdict == "infeasible"
    (tmp_path / "other.yaml").write_text("{}")
    assert next(edits).report.verdict == "infeasible"
