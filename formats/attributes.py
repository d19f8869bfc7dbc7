"""Attributes of XML elements as checked numbers and words; every refusal names the element's line."""

from __future__ import annotations

import math
from collections.abc import Mapping

from formats.xml_elements import Element, refuse
from schemas.robot_description import SourceLine

Attributes = Mapping[str, str]


def numbers(
    a: Attributes, name: str, count: int | None, default: tuple[float, ...] | None, source: SourceLine
) -> tuple[float, ...]:
    """The numbers of an attribute, separated by blanks or commas; any number of them where `count` is None.

    Raises InvalidInput `robot/invalid-number` unless there are `count` finite ones, or where it is absent without a
    default.
    """
    text = a.get(name)
    if text is None and default is not None:
        return default
    words = (text or "").replace(",", " ").split()
    try:
        values = tuple(float(word) for word in words)
    except ValueError:
        values = ()
    right_count = len(values) == (len(words) if count is None else count)
    if not right_count or "_" in (text or "") or not all(math.isfinite(v) for v in values):
        needed = "finite numbers" if count is None else f"{count} finite number{'s' if count > 1 else ''}"
        headline = f"'{name}' is absent" if text is None else f"{name}='{text[:80]}' should be {needed}"
        refuse("robot/invalid-number", headline, source, value=(text or "")[:80], bound=needed)
    return values


def number(a: Attributes, name: str, default: float | None, source: SourceLine) -> float:
    """One number; see `numbers`."""
    return numbers(a, name, 1, None if default is None else (default,), source)[0]


def vector(
    a: Attributes, name: str, default: tuple[float, float, float] | None, source: SourceLine
) -> tuple[float, float, float]:
    """Three numbers; see `numbers`."""
    x, y, z = numbers(a, name, 3, default, source)
    return x, y, z


def flag(a: Attributes, name: str, default: bool, source: SourceLine) -> bool:
    """`true` or `false`. Raises InvalidInput `robot/invalid-value` for another word."""
    return choice(a, name, ("true", "false"), "true" if default else "false", source) == "true"


def choice(a: Attributes, name: str, words: tuple[str, ...], default: str, source: SourceLine) -> str:
    """One of the words. Raises InvalidInput `robot/invalid-value` for another one."""
    word = a.get(name, default)
    if word not in words:
        refuse("robot/invalid-value", f"{name}='{word[:80]}' is not known", source, word[:80], " ".join(words))
    return word


def name_of(element: Element) -> str:
    """The attribute `name`. Raises InvalidInput `robot/missing-name`."""
    name = element.get("name")
    if not name:
        refuse("robot/missing-name", f"a <{element.tag}> has no name", element.source)
    return name
