"""Findings about a text with its lines, as compilers show them: place, lines, what is underlined and why, help."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from itertools import groupby, pairwise
from pathlib import Path

from rich.markup import escape
from rich.text import Text

from cli import text
from schemas.diagnostics import Diagnostic, Location

_STYLE = {"error": "bold red", "warning": "bold yellow", "info": "bold cyan"}
_BRACKETS = {"{": "}", "[": "]"}
Mark = tuple[Location, str, bool]  # place, words, whether it is the main one


def show(diagnostics: Iterable[Diagnostic], root: Path) -> None:
    """Print findings whose files are named relative to `root`."""
    _text_of.cache_clear()
    for diagnostic in diagnostics:
        text.console.print("\n".join(_lines(diagnostic, root)), soft_wrap=True, highlight=False)
        text.console.print()


def plain(diagnostics: Iterable[Diagnostic], root: Path) -> str:
    """The same as text without colours."""
    return "\n\n".join(Text.from_markup("\n".join(_lines(d, root))).plain for d in diagnostics)


def _lines(diagnostic: Diagnostic, root: Path, indent: str = "") -> list[str]:
    """The finding as lines of rich markup."""
    style = _STYLE[diagnostic.severity.value]
    head = f"[{style}]{diagnostic.severity.value}\\[{diagnostic.code}][/]: [bold]{escape(diagnostic.headline)}[/]"
    lines = [indent + head]
    marks = _marks(diagnostic)
    gutter = max([len(str(at.line)) for at, _, _ in marks], default=1)
    blank = f"{indent}{' ' * gutter} [blue]|[/]"
    for file, group in groupby(marks, key=lambda mark: mark[0].file):
        here = list(group)
        main = next((at for at, _, first in here if first), here[0][0])
        lines.append(f"{indent}{' ' * gutter}[blue]-->[/] {escape(str(main))}")
        lines.append(blank)
        lines += _excerpt(here, _text_of(root, file), gutter, indent, style)
    if not marks and str(diagnostic.where) != "(whole asset)":
        lines.append(f"{indent}{' ' * gutter}[blue]-->[/] {escape(str(diagnostic.where))}")
    note = f"{indent}{' ' * gutter} [blue]=[/]"
    if diagnostic.value is not None:
        lines.append(f"{note} {escape(_figures(diagnostic))}")
    for cause in diagnostic.because:
        lines.append(f"{note} because")
        lines += _lines(cause, root, indent + " " * (gutter + 3))
    if diagnostic.help:
        lines.append(f"{note} [bold]help[/]: {escape(diagnostic.help)}")
    return lines


def _marks(diagnostic: Diagnostic) -> list[Mark]:
    """All places with a line, by file and line, the file of the main one first; one mark a place."""
    marks: dict[Location, Mark] = {}
    if diagnostic.where.line is not None:
        marks[diagnostic.where] = (diagnostic.where, "", True)
    for label in diagnostic.labels:
        if label.where.line is not None:
            marks[label.where] = (label.where, label.text, label.where == diagnostic.where)
    main = diagnostic.where.file
    return sorted(marks.values(), key=lambda m: (m[0].file != main, m[0].file or "", m[0].line or 0, m[0].column or 0))


def _excerpt(marks: list[Mark], source: tuple[str, ...], gutter: int, indent: str, style: str) -> list[str]:
    """The lines that carry marks, each mark underlined below its line; left-out lines are dots."""
    lines_shown: list[str] = []
    shown = sorted({at.line for at, _, _ in marks if at.line is not None})
    skips = {b for a, b in pairwise(shown) if b > a + 1}
    for number in shown:
        if number in skips:
            lines_shown.append(f"{indent}[blue]...[/]")
        line = source[number - 1] if number <= len(source) else ""
        lines_shown.append(f"{indent}[blue]{number:>{gutter}} |[/] {escape(_visible(line))}")
        for at, words, main in marks:
            if at.line == number:
                start = (at.column or 1) - 1
                under = ("^" if main else "-") * max(1, _end(line, start) - start)
                colour = style if main else "blue"
                said = f" {escape(words)}" if words else ""
                lines_shown.append(f"{indent}{' ' * gutter} [blue]|[/] {' ' * start}[{colour}]{under}{said}[/]")
    return lines_shown


def _visible(line: str) -> str:
    """The line with a sign of the same width for each character that would act on a terminal."""
    return "".join(c if c.isprintable() or c == "\t" else "\N{REPLACEMENT CHARACTER}" for c in line)


def _end(line: str, start: int) -> int:
    """Where what begins at `start` ends on its line: its closing bracket, the next comma or brace, or a comment."""
    depth: list[str] = []
    for index in range(start, len(line)):
        char = line[index]
        if char in _BRACKETS:
            depth.append(_BRACKETS[char])
        elif depth and char == depth[-1]:
            depth.pop()
            if not depth and line[start] in _BRACKETS:
                return index + 1
        elif not depth and (char in ",}]" or line[index : index + 2] == " #"):
            return index
    return len(line.rstrip())


@cache  # Emptied by `show`: a file may have been saved since.
def _text_of(root: Path, file: str | None) -> tuple[str, ...]:
    """The lines of a source file; none when it cannot be read (the place still says where)."""
    try:
        return tuple((root / (file or "")).read_text(encoding="utf-8").splitlines())
    except (OSError, UnicodeDecodeError):
        return ()


def _figures(diagnostic: Diagnostic) -> str:
    bound = "" if diagnostic.bound is None else f", bound {text.figure(diagnostic.bound)}"
    unit = f" {diagnostic.unit}" if diagnostic.unit else ""
    return f"found {text.figure(diagnostic.value)}{bound}{unit}"
