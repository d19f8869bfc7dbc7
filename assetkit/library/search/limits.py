"""Parses limits of size (m) and mass (kg) in a request: "under 10 cm", "between 5 and 8 in", "at least 200 g"."""

from __future__ import annotations

import re
from collections.abc import Mapping

from assetkit.library.search.query import Criterion, Field

ABOUT = 0.2  # "About 10 cm", or just "10 cm": within 20 %.
_LENGTH_M = {"mm": 0.001, "cm": 0.01, "m": 1.0, "meter": 1.0, "metre": 1.0, "in": 0.0254, "inch": 0.0254, "ft": 0.3048}
_MASS_KG = {"g": 0.001, "gram": 0.001, "kg": 1.0, "lb": 0.4536, "lbs": 0.4536, "oz": 0.02835}
_MOST = (
    "(?:not|no) (?:over|above|(?:more|larger|bigger|longer|taller|higher|heavier) than)|"
    "under|below|less than|smaller than|shorter than|lighter than|lower than|at most|max|maximum|up to|<=?"
)
_LEAST = (
    "(?:not|no) (?:under|below|(?:less|smaller|shorter|lighter|lower) than)|"
    "over|above|more than|larger than|bigger than|longer than|taller than|higher than|heavier than|at least|min|>=?"
)
_PLURALS = {"inches": "inch", "meters": "meter", "metres": "metre", "grams": "gram"}
_THOUSANDS = r"\d{1,3}(?:,\d{3})+(?:\.\d+)?"
_NUMBER = rf"(?:{_THOUSANDS}|\d*[.,]\d+|\d+)"


def _pattern(units: Mapping[str, float]) -> re.Pattern[str]:
    """Limits in these units; "and" joins two figures only behind "between" or "from"."""
    unit = "|".join(
        sorted((*units, *(p for p, singular in _PLURALS.items() if singular in units)), key=len, reverse=True)
    )
    return re.compile(
        rf"(?:(?P<most>{_MOST})|(?P<least>{_LEAST})|(?:about|around|roughly)|(?P<span>between|from))?\s*"
        rf"(?<![\w.,])(?P<first>{_NUMBER})"
        rf"(?:\s*(?P<first_unit>{unit})?\s*(?:(?(span)and|to)|to|-)\s*(?P<second>{_NUMBER}))?\s*(?P<unit>{unit})\b"
        r"(?:\s+(?P<upright>tall|high|in height)\b|\s+(?:long|wide|across|in size|in length)\b)?"
    )


_KINDS: tuple[tuple[Field, Mapping[str, float], re.Pattern[str]], ...] = (
    ("size_m", _LENGTH_M, _pattern(_LENGTH_M)),
    ("mass_kg", _MASS_KG, _pattern(_MASS_KG)),
)


def read_limits(request: str) -> tuple[tuple[Criterion, ...], str]:
    """The limits in a lower-case request, and what is left of it.

    A length limits the longest edge of the bounding box of the asset, or its height where the words are about height.
    """
    criteria: list[Criterion] = []
    for field, units, pattern in _KINDS:
        criteria += [_criterion(match, field, units) for match in pattern.finditer(request)]
        request = pattern.sub(" ; ", request)
    return tuple(criteria), request


def limit_of(text: str, field: Field) -> float:
    """A figure with its unit, "10cm" or "0.5 kg", in metres or kilograms. Raises ValueError when it is none."""
    units = _MASS_KG if field == "mass_kg" else _LENGTH_M
    match = re.fullmatch(rf"\s*({_NUMBER})\s*([a-z]+)\s*", text.lower())
    if match is None or _singular(match[2]) not in units:
        raise ValueError(f"'{text}' is no figure with a unit ({', '.join(units)})")
    return _figure(match[1]) * units[_singular(match[2])]


def _criterion(match: re.Match[str], field: Field, units: Mapping[str, float]) -> Criterion:
    scale = units[_singular(match["unit"])]
    if field == "size_m" and (match["upright"] or re.search("taller|higher|lower", match[0])):
        field = "height_m"
    first = _figure(match["first"]) * (units[_singular(match["first_unit"])] if match["first_unit"] else scale)
    if match["second"]:
        low, high = sorted((first, _figure(match["second"]) * scale))
    elif match["most"]:
        low, high = 0.0, first
    elif match["least"]:
        low, high = first, float("inf")
    else:
        low, high = first * (1 - ABOUT), first * (1 + ABOUT)
    return Criterion(match[0].strip(), field, low=low, high=high, reading=f"{field} {low:.4g} to {high:.4g}")


def _singular(unit: str) -> str:
    return _PLURALS.get(unit, unit)


def _figure(text: str) -> float:
    return float(text.replace(",", "" if re.fullmatch(_THOUSANDS, text) else "."))
