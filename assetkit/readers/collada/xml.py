"""XML of a COLLADA file: safe parsing, references by id, numbers as exporters really write them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from lxml import etree

from assetkit.readers.common.corners import Notes, repaired
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding

Element: TypeAlias = etree._Element
_EXTERNAL_ENTITY = re.compile(rb"<!ENTITY[^>]*\b(SYSTEM|PUBLIC)\b|<!DOCTYPE[^>\[]*\b(SYSTEM|PUBLIC)\b", re.IGNORECASE)
_ENTITY = re.compile(rb"<!ENTITY", re.IGNORECASE)
_ENCODING = re.compile(rb"""\A\s*<\?xml[^>]*encoding\s*=\s*["']([A-Za-z0-9._-]+)""")
_ENCODINGS = frozenset({b"utf-8", b"utf8", b"us-ascii", b"ascii", b"iso-8859-1", b"latin1", b"windows-1252", b"utf-16"})
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_MSVC = re.compile(r"[+-]?\d\.#\w+")


@dataclass
class Document:
    """A parsed file. Tags are local names, without namespace; `notes` grows while the file is read."""

    root: Element
    where: Location
    notes: Notes = field(default_factory=Notes)
    by_id: dict[str, Element] = field(default_factory=dict)
    _reported: set[str] = field(default_factory=set)

    def place(self, element: Element) -> Location:
        """Where `element` begins."""
        return Location(file=self.where.file, line=element.sourceline)

    def find(self, url: str | None, tag: str) -> Element | None:
        """The element a fragment reference such as "#id" names, if it has that tag."""
        element = self.by_id.get((url or "").strip().removeprefix("#"))
        return element if element is not None and element.tag == tag else None

    def report(
        self, diagnostic: Diagnostic, repair: str | None = None, *, once: str = "", **before: str | float
    ) -> None:
        """Add a finding, with its repair if it has one; with `once` set, only the first under that key."""
        if once and once in self._reported:
            return
        self._reported.add(once)
        self.notes += repaired(diagnostic, repair, **before) if repair else Notes((diagnostic,))

    def numbers(self, element: Element) -> np.ndarray:
        """(n,) float64 values of the element's text; decimal commas are read as points and reported once.

        Raises ValueError for anything that is not a number.
        """
        text = element.text or ""
        try:
            return np.fromiter(map(float, text.split()), dtype=np.float64)
        except ValueError:
            pass
        tokens = text.split()
        if any(_DECIMAL_COMMA.fullmatch(t) for t in tokens):
            headline = "numbers are written with decimal commas"
            diagnostic = finding(
                "asset/schema-error", headline, where=self.place(element), value=tokens[0], severity=Severity.WARNING
            )
            self.report(diagnostic, "decimal_comma", once="decimal comma", example=tokens[0])
            tokens = [t.replace(",", ".") for t in tokens]
        return np.array([float("nan") if _MSVC.fullmatch(t) else float(t) for t in tokens], dtype=np.float64)


def parse(data: bytes, where: Location) -> Document:
    """The document in `data`. Nothing outside it is ever opened and no entity is ever expanded.

    Raises InvalidInput: `asset/path-escape` for external entities or document types, `asset/resource-limit` for any
    other entity declaration, `asset/parse-error` with line and column for XML errors and unusual encodings.
    """
    plain = data.replace(b"\x00", b"")  # UTF-16 and UTF-32 hide nothing then
    if _EXTERNAL_ENTITY.search(plain):
        raise InvalidInput(finding("asset/path-escape", "the file declares an external XML entity", where=where))
    if _ENTITY.search(plain):
        raise InvalidInput(finding("asset/resource-limit", "the file declares XML entities", where=where))
    encoding = _ENCODING.match(plain.lstrip(b"\xef\xbb\xbf\xff\xfe"))
    if encoding and encoding.group(1).lower() not in _ENCODINGS:
        name = encoding.group(1).decode("ascii")
        raise InvalidInput(finding("asset/parse-error", f"XML encoding '{name}' is not read", where=where, value=name))
    # Long text nodes are normal here (coordinates), and with entities excluded huge_tree only lifts their limit.
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True, remove_comments=True, remove_pis=True
    )
    try:
        root = etree.fromstring(data.removeprefix(b"\xef\xbb\xbf").lstrip(), parser)
    except etree.XMLSyntaxError as error:
        line, column = error.position
        raise InvalidInput(
            finding(
                "asset/parse-error",
                f"XML: {error.msg}",
                where=Location(file=where.file, line=line, column=max(column, 1)),
            )
        ) from None
    document = Document(root, where)
    for element in root.iter("*"):
        element.tag = etree.QName(element).localname
        if (name := element.get("id")) is not None:
            document.by_id.setdefault(name, element)
    if root.tag != "COLLADA":
        raise InvalidInput(
            finding("asset/wrong-content", f"the root element is <{root.tag}>, not <COLLADA>", where=where)
        )
    return document
