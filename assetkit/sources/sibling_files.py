"""Statements about the unit of a mesh in files beside it: robot descriptions that scale it, notes of its name."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from assetkit.sources.source_file import SourceFile

_DESCRIPTIONS = {".urdf", ".xacro", ".xml", ".mjcf", ".sdf"}
_NOTES = (".json", ".txt", ".yaml", ".yml", ".md")
_MAX_SIBLING_BYTES, _MAX_FILES = 1_000_000, 32
_ELEMENT = re.compile(r"<(?:\w+:)?mesh\b[^<>]*>(?:(?!</mesh>|<mesh\b).){0,400}", re.DOTALL)
_SCALE = re.compile(r"""\bscale\s*=\s*["']([^"']*)["']|<scale>([^<]*)</scale>""")
_UNIT = re.compile(r"\bunits?\b", re.IGNORECASE)
_MAX_STATEMENTS = 50


def sibling_statements(source: SourceFile) -> tuple[str, ...]:
    """Lines such as "1 unit = 0.001 m (scale in arm.urdf)", sorted, for every file beside the source that has one.

    For formats without a unit only: to others a description's scale comes on top of their own unit. Nothing above the
    root is read; files with a statement become part of the asset's source files.
    """
    statements: list[str] = []
    for path in _files_beside(source):
        text = _text(path)
        if path.suffix.lower() in _DESCRIPTIONS:
            in_file = [
                f"1 unit = {s:.9g} m (scale in {path.name})" for s in sorted(set(_scales(text, source.path.name)))
            ]
        else:
            in_file = [f"{passage} ({path.name})" for passage in _passages(text)]
        if in_file:
            source.visited.add(path)
            statements += in_file[:_MAX_STATEMENTS]
    return tuple(statements)


def _files_beside(source: SourceFile) -> list[Path]:
    """Descriptions in the folders from the source up to its root, and notes that share its stem, with links followed.

    Notes that are not there yet are logged as missing: they would count if they appeared.
    """
    root = source.root.resolve()
    main_file = source.path.resolve()
    folders = [f for f in main_file.parents if f.is_relative_to(root)]
    listed = (p for f in folders for p in sorted(f.iterdir()) if p.suffix.lower() in _DESCRIPTIONS)
    paths = [p for p, _ in zip(listed, range(_MAX_FILES), strict=False)]
    notes = [main_file.with_suffix(suffix) for suffix in _NOTES if suffix != main_file.suffix]
    source.missing.update(p.relative_to(root).as_posix() for p in notes if not p.exists())
    real = (_followed(p) for p in (*paths, *notes))
    return [p for p in real if p is not None and p.is_file() and p.is_relative_to(root)]


def _followed(path: Path) -> Path | None:
    try:
        return path.resolve()
    except (OSError, RuntimeError):  # A circle of links.
        return None


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file.read(_MAX_SIBLING_BYTES).decode("utf-8", "ignore")
    except OSError:
        return ""


def _passages(text: str) -> list[str]:
    """The first lines about units, each at most 40 characters either side of the word."""
    excerpts = (text[max(0, m.start() - 40) : m.end() + 40] for m in islice(_UNIT.finditer(text), _MAX_STATEMENTS))
    return list(dict.fromkeys(next(line for line in p.splitlines() if _UNIT.search(line)).strip() for p in excerpts))


def _scales(text: str, name: str) -> Iterator[float]:
    """The uniform scales under which a robot description loads the file `name`; 1 where none is stated."""
    for element in _ELEMENT.findall(text):
        if not re.search(rf"""[/"'>\s]{re.escape(name)}["'<\s]""", element):
            continue
        match = _SCALE.search(element)
        try:
            numbers = [float(n) for n in (match[1] or match[2] or "").split()] if match else [1.0]
        except ValueError:
            continue
        if numbers and min(numbers) > 0 and max(numbers) <= min(numbers) * 1.001:
            yield numbers[0]
