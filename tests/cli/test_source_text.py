"""Findings beside their lines: what is underlined, in which order, and that nothing is lost when a file is gone."""

from __future__ import annotations

from pathlib import Path

from cli.source_text import plain
from schemas.diagnostics import Label, Location, finding

TEXT = """\
relations:
  - {left_of: [a, b], gap: 0.1}  # first
  - {behind: [c, d]}
  - {left_of: [b, a]}
"""


def at(line: int, column: int, file: str = "p.yaml") -> Location:
    return Location(file=file, line=line, column=column)


def test_lines_are_shown_as_written_with_what_is_meant_underlined(tmp_path: Path):
    (tmp_path / "p.yaml").write_text(TEXT)
    labels = (Label(where=at(4, 5), text="relations[2]"), Label(where=at(2, 5), text="relations[0]"))
    found = finding("scene/relation-cycle", "a circle", where=at(2, 5), labels=labels, value=0.25, bound=0.0, unit="m")
    assert plain([found], tmp_path).splitlines()[:9] == [
        "error[scene/relation-cycle]: a circle",
        " --> p.yaml:2:5",
        "  |",
        "2 |   - {left_of: [a, b], gap: 0.1}  # first",
        "  |     ^^^^^^^^^^^^^^^^^^^^^^^^^^^ relations[0]",
        "...",
        "4 |   - {left_of: [b, a]}",
        "  |     ----------------- relations[2]",
        "  = found 0.25, bound 0 m",
    ]


def test_a_value_ends_before_the_comma_or_the_comment(tmp_path: Path):
    (tmp_path / "p.yaml").write_text("a: 12 # twelve\nb: {c: 3, d: 4}\n")
    shown = plain(
        [finding("scene/invalid-value", "x", where=at(1, 4)), finding("scene/invalid-value", "y", where=at(2, 8))],
        tmp_path,
    )
    assert "  |    ^^\n" in shown
    assert "  |        ^\n" in shown


def test_markup_in_a_program_is_text(tmp_path: Path):
    (tmp_path / "p.yaml").write_text("x: [bold]\n")
    assert "1 | x: [bold]" in plain([finding("scene/invalid-value", "[red] no", where=at(1, 4))], tmp_path)


def test_a_file_that_is_gone_leaves_the_place(tmp_path: Path):
    assert "--> gone.yaml:7:2" in plain([finding("scene/invalid-value", "x", where=at(7, 2, "gone.yaml"))], tmp_path)
