"""Elements as XML text, with two blanks for each level; in time linear in their number, however deep they lie."""

from __future__ import annotations

from collections.abc import Iterable

from formats.xml_elements import Element, synthetic

_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\r": "&#13;", "\n": "&#10;", "\t": "&#09;"}
_ESCAPE_TABLE = str.maketrans(_ESCAPES)


def element(tag: str, *children: Element | None, **attributes: str) -> Element:
    """A new element; children that are None are left out."""
    xml = synthetic(tag, attributes)
    xml.children = [child for child in children if child is not None]
    return xml


def to_bytes(top: Element) -> bytes:
    """The element and all below it as a UTF-8 document."""
    lines = ["<?xml version='1.0' encoding='utf-8'?>"]
    waiting: list[tuple[Element, int, bool]] = [(top, 0, False)]
    while waiting:
        at, level, closes = waiting.pop()
        indent = "  " * level
        if closes:
            lines.append(f"{indent}</{at.tag}>")
            continue
        start = "".join(f' {key}="{value.translate(_ESCAPE_TABLE)}"' for key, value in at.attributes.items())
        lines.append(f"{indent}<{at.tag}{start}{'>' if at.children else ' />'}")
        if at.children:
            waiting.append((at, level, True))
            waiting += [(child, level + 1, False) for child in reversed(at.children)]
    return "\n".join(lines).encode()


def number_text(value: float) -> str:
    """The shortest decimal that reads back as the same double."""
    return repr(float(value))


def numbers_text(values: Iterable[float]) -> str:
    """Numbers with blanks between them."""
    return " ".join(number_text(value) for value in values)
