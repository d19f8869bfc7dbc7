"""Clues to the unit outside the numbers: sizes and units in comments and names, conversion factors in scaled nodes.

`assetkit.scale.declared_units` weighs the clues against the declared unit and the size that results.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import PurePosixPath

import numpy as np

from assetkit.options import METERS_PER_UNIT
from schemas.model import Node

# Metres per unit, and how texts call the unit. One-letter names count only where nothing else can be meant.
_UNITS: dict[str, tuple[float, str]] = {
    "um": (1e-6, r"microns?|micromet(?:er|re)s?|[µμ]m"),
    "mm": (1e-3, r"mm|millimet(?:er|re)s?"),
    "cm": (1e-2, r"cm|centimet(?:er|re)s?"),
    "dm": (1e-1, r"dm|decimet(?:er|re)s?"),
    "m": (1.0, r"met(?:er|re)s?"),
    "in": (0.0254, r"inch(?:es)?"),
    "ft": (0.3048, r"foot|feet|ft"),
}
_SHORT = {"m": 1.0, "in": 0.0254}
_ANY = "|".join(name for _, name in _UNITS.values())
_NUMBER = r"(\d+(?:\.\d*)?(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?)"
_SUBJECT = r"\b(?:units?|scale|exported|measured|dimensions?|coordinates?|lengths?)\b"

_ONE_UNIT_IS = re.compile(rf"\b(?:units?|uu|bu)\s*(?:=|:|is|equals)\s*{_NUMBER}\s*(m|in|{_ANY})\b")
_SIZE = re.compile(rf"{_NUMBER}\s*(?:{_ANY}|m|in)\b")  # "80 mm" is the size of something, not the unit of the numbers.
_LENGTH_PER_UNIT = re.compile(rf"\b({_ANY})[\s_-]*per[\s_-]*units?\b\W{{0,4}}{_NUMBER}?")
_UNITS_PER_LENGTH = re.compile(rf"\bunits?[\s_-]*(?:per|/)[\s_-]*({_ANY})\b\W{{0,4}}{_NUMBER}?")
_ORIGIN = re.compile(rf"\bfrom\s+(?:{_ANY}|m|in)\b")  # "converted from mm to m": only the second counts.
_SUBJECT_THEN_UNIT = {u: re.compile(rf"{_SUBJECT}[^\n]{{0,24}}?\b(?:{n})\b") for u, (_, n) in _UNITS.items()}
_UNIT_THEN_SUBJECT = {
    u: re.compile(rf"\b(?:{n})\s+(?:(?:as|are|is)\s+(?:the\s+)?)?(?:\w+\s+)?units?\b") for u, (_, n) in _UNITS.items()
}
_SUBJECT_THEN_SHORT = re.compile(
    rf"(?:{_SUBJECT}[^\n]{{0,16}}?(?:[=:][\s\"']*|\b(?:in|of)\s+)|\bunits?\s+)(m|in)\b[\"']?\s*(?:$|[;,.)}}])"
)
_NAMED_SIZE = re.compile(r"((?:\d+(?:[.,]\d+)?\s*x\s*)*\d+(?:[.,]\d+)?)\s*[_-]?(mm|cm|m|inch|in)(?![a-z0-9])")
_NAMED_UNIT = re.compile(
    r"(?:^|[^a-z0-9])(mm|cm|inch|inches|millimet(?:er|re)s?|centimet(?:er|re)s?|met(?:er|re)s)(?![a-z0-9])"
)
_NAME_TOLERANCE = 0.03
MAX_LINE, MAX_LINES = 300, 500  # Remarks are short and stand at the beginning; texts without end are no remarks.

# Factors between two common units: a whole model scaled by one of these was converted, perhaps once too often.
_CONVERSIONS = (1000.0, 100.0, 1 / 0.0254, 0.0254, 0.01, 0.001)


Extent = tuple[float, float, float]


@dataclass(frozen=True)
class UnitClue:
    """One clue to the unit: metres per unit, confidence, kind of clue, and the words or figure quoted."""

    meters_per_unit: float
    confidence: float
    method: str
    quote: str


def stated_in_text(texts: Sequence[str], extent: Extent) -> list[UnitClue]:
    """Clues in comments, headers and free attributes, one per line and unit.

    `extent` is the bounding box in source units: a line with the size of the object ("120 x 80 x 30 mm") gives
    the unit of the numbers only together with them.
    """
    clues: list[UnitClue] = []
    for line in islice((line[:MAX_LINE] for text in texts for line in text.splitlines()), MAX_LINES):
        text = _ORIGIN.sub("", line.lower())
        scales, method = _stated_in_line(text), "statement in the file's texts"
        if not scales:
            scales, method = set(_sizes_that_fit(text, extent)), "size stated in the file's texts"
            scales = scales if len(scales) == 1 else set()
        clues += [UnitClue(s, 0.9, method, line.strip()[:80]) for s in sorted(scales)]
    return clues


def _stated_in_line(line: str) -> set[float]:
    """The scales a line states: an equation counts before a unit that is merely named."""
    if match := _ONE_UNIT_IS.search(line):
        return _possible(float(match[1]) * _metres(match[2]))
    if match := _LENGTH_PER_UNIT.search(line):
        return _possible(float(match[2]) * _metres(match[1])) if match[2] else set()
    if match := _UNITS_PER_LENGTH.search(line):
        return _possible(_metres(match[1]) / float(match[2])) if match[2] and float(match[2]) > 0 else set()
    line = _SIZE.sub("", line)
    scales = {
        scale
        for unit, (scale, _) in _UNITS.items()
        if _SUBJECT_THEN_UNIT[unit].search(line) or _UNIT_THEN_SUBJECT[unit].search(line)
    }
    if not scales and (match := _SUBJECT_THEN_SHORT.search(line)):
        return {_SHORT[match[1]]}
    return scales


def _possible(scale: float) -> set[float]:
    return {scale} if 1e-7 <= scale <= 1e4 else set()


def _metres(name: str) -> float:
    return _SHORT.get(name) or next(s for s, pattern in _UNITS.values() if re.fullmatch(pattern, name))


def stated_in_name(name: str, extent: Extent) -> list[UnitClue]:
    """Clues in a file or folder name: a size that the mesh has ("20mm-cube") or a unit as a word ("lid_mm").

    `name` is a path; `extent` the bounding box in source units. A size that fits two units is no clue.
    """
    sized = {s for part in PurePosixPath(name).parts for s in _sizes_that_fit(part.lower(), extent)}
    if len(sized) == 1:
        return [UnitClue(sized.pop(), 0.9, "size named in the file name", name)]
    words = {m[1] for part in PurePosixPath(name).parts for m in _NAMED_UNIT.finditer(part.lower())}
    scales = {_metres(w) for w in words}
    return [UnitClue(s, 0.7, "unit named in the file or folder name", name) for s in sorted(scales)]


def _sizes_that_fit(name: str, extent: Extent) -> Iterator[float]:
    """Scales of common units under which the mesh has every length of a size in `name`."""
    for numbers, unit in _NAMED_SIZE.findall(name):
        lengths = [float(n.replace(",", ".")) * _metres(unit) for n in numbers.split("x")]
        for scale in METERS_PER_UNIT.values():
            if all(any(math.isclose(w, e * scale, rel_tol=_NAME_TOLERANCE) for e in extent) for w in lengths):
                yield scale


def scaled_nodes(nodes: Sequence[Node], meters_per_unit: float) -> list[UnitClue]:
    """The scale that would hold without a conversion factor (1000, 100, 39.37 or inverse) that all meshes share.

    Chains of exporters write such a factor into the top node, and some apply it although it was applied before.
    """
    local = {node.path: node.X_PN for node in nodes}
    totals: list[float] = []
    for node in (n for n in nodes if n.meshes):
        X = np.eye(3)
        for path in (node.path, *(str(p) for p in PurePosixPath(node.path).parents)):
            X = local[path][:3, :3] @ X if path in local else X
        lengths = np.linalg.norm(X, axis=0)
        if not np.isfinite(lengths).all() or lengths.max() > 1.001 * max(lengths.min(), 1e-30):
            return []
        totals.append(float(lengths.mean()))
    factor = next((f for f in _CONVERSIONS if totals and all(math.isclose(t, f, rel_tol=2e-3) for t in totals)), None)
    if factor is None:
        return []
    quote = f"every mesh stands below a node scale of {factor:.4g}"
    return [UnitClue(meters_per_unit / factor, 0.6, "conversion factor in the node hierarchy", quote)]
