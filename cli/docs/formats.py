"""The page `docs/reference/file-formats.md` from the table of source formats: one row per format."""

from __future__ import annotations

from assetkit.readers.by_format import FORMATS
from assetkit.readers.source_format import SourceFormat

_INTRODUCTION = """# Source formats

`mana assets ingest` reads files with these extensions. A file whose content contradicts its extension is refused
(`asset/wrong-content`); models of other types are reported (`asset/format-unsupported`).
[How to add a format](../contributing/file-format.md).

| format | extensions | begins with | names other files | habit of units |
|---|---|---|---|---|
"""
_HABITS = {"none": "", "cad": "CAD and printing: millimetres"}


def page() -> str:
    """The page as text."""
    return _INTRODUCTION + "".join(_row(row) for row in FORMATS)


def _row(row: SourceFormat) -> str:
    contents = dict.fromkeys([signature.content for signature in row.magic] + ([row.syntax] if row.syntax else []))
    cells = [row.name, ", ".join(row.extensions), ", ".join(contents), ", ".join(row.referring)]
    return "| " + " | ".join([*cells, _HABITS[row.unit_habit]]) + " |\n"
