"""XML text as elements with attributes, children, line and source text; no entity is ever expanded.

Parsed by expat (docs.python.org/3/library/pyexpat.html). Robot descriptions need no document type, so a file that
declares entities or names an external document type is refused before anything in it is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from schemas.diagnostics import InvalidInput, finding
from schemas.files.regular_file import read_regular
from schemas.robot_description import NOWHERE, SourceLine

MAX_DESCRIPTION_BYTES = 50_000_000  # the largest descriptions with meshes written in them have some 10 MB


def refuse(
    code: str, headline: str, source: SourceLine, value: float | str | None = None, bound: float | str | None = None
) -> NoReturn:
    """Raise InvalidInput with a finding at a place in a description."""
    raise InvalidInput(finding(code, headline, where=source.location, value=value, bound=bound))


@dataclass
class Element:
    """One element. `span` is the place of its text in `data`; children of included files bring their own."""

    tag: str
    attributes: dict[str, str]
    source: SourceLine
    data: bytes = field(default=b"", repr=False)
    span: tuple[int, int] = (0, 0)
    children: list[Element] = field(default_factory=list["Element"])

    def named(self, tag: str) -> list[Element]:
        """The children with a tag, in order."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> Element | None:
        """The first child with a tag; None without one."""
        return next((child for child in self.children if child.tag == tag), None)

    def get(self, name: str, default: str = "") -> str:
        """An attribute, or the default where it is absent."""
        return self.attributes.get(name, default)

    @property
    def text(self) -> str:
        """The element as the file has it."""
        return self.data[self.span[0] : self.span[1]].decode("utf-8", "replace")

    def walk(self) -> Iterator[Element]:
        """The element and all below it, parents first."""
        waiting: list[Element] = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))


def parse_file(path: Path, root: Path) -> Element:
    """The outermost element of a file inside the folder `root`, links followed.

    Raises InvalidInput (`robot/path-escape`, `robot/missing-file`, `robot/unreadable`, `robot/xml-declarations`).
    """
    source = SourceLine(file_name(path, root))
    if not path.resolve().is_relative_to(root.resolve()):
        refuse("robot/path-escape", f"'{path.name}' lies outside the folder of the description", source)
    try:
        if path.stat().st_size > MAX_DESCRIPTION_BYTES:
            refuse("robot/unreadable", f"more than {MAX_DESCRIPTION_BYTES} bytes", source, value=path.stat().st_size)
        data = read_regular(path)
    except OSError as error:
        refuse("robot/missing-file", f"'{path.name}': {error.strerror}", source)
    return parse_bytes(data, source.file)


def file_name(path: Path, root: Path) -> str:
    """The path relative to the root, as diagnostics give it; the bare name outside."""
    try:
        return path.resolve().relative_to(root.resolve()).as_posix()
    except ValueError:
        return path.name


def parse_bytes(data: bytes, file: str) -> Element:
    """The outermost element of XML text; `file` is what lines refer to. Raises InvalidInput."""
    if len(data) > MAX_DESCRIPTION_BYTES:
        refuse("robot/unreadable", f"more than {MAX_DESCRIPTION_BYTES} bytes", SourceLine(file), value=len(data))
    return _Parser(data, file).run()


class _Parser:
    """One pass of expat over one file."""

    def __init__(self, data: bytes, file: str) -> None:
        self.data, self.file = data, file
        self.open: list[Element] = []
        self.top: Element | None = None
        self.expat = expat.ParserCreate()
        self.expat.StartElementHandler = self._start
        self.expat.EndElementHandler = self._end
        self.expat.StartDoctypeDeclHandler = self._document_type
        self.expat.EntityDeclHandler = self._entity

    def run(self) -> Element:
        try:
            self.expat.Parse(self.data, True)
        except expat.ExpatError as error:
            source = SourceLine(self.file, error.lineno)
            refuse("robot/unreadable", f"no well-formed XML: {expat.ErrorString(error.code)}", source)
        except (ValueError, LookupError) as error:  # An encoding that Python or expat does not know.
            refuse("robot/unreadable", f"no readable XML: {error}", SourceLine(self.file))
        if self.top is None:
            refuse("robot/unreadable", "no XML element", SourceLine(self.file))
        return self.top

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        source = SourceLine(self.file, self.expat.CurrentLineNumber)
        at = self.expat.CurrentByteIndex
        element = Element(tag, attributes, source, self.data, (at, at))
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.top = element
        self.open.append(element)

    def _end(self, tag: str) -> None:
        element = self.open.pop()
        at = self.expat.CurrentByteIndex
        empty = not element.children and self.data[at - 2 : at] == b"/>"  # Then the place is behind the element.
        element.span = (element.span[0], at if empty else self.data.find(b">", at) + 1)

    def _document_type(self, name: str, system: str | None, public: str | None, has_internal_subset: bool) -> None:
        if system or public or has_internal_subset:
            self._declared(f"<!DOCTYPE {name} ...> with declarations")

    def _entity(self, name: str, *_: object) -> None:
        self._declared(f"the entity '{name}' is declared")

    def _declared(self, headline: str) -> NoReturn:
        refuse("robot/xml-declarations", headline, SourceLine(self.file, self.expat.CurrentLineNumber))


def synthetic(tag: str, attributes: dict[str, str]) -> Element:
    """An element that no file has, with defaults."""
    return Element(tag, attributes, NOWHERE)
