"""Parses the PLY container: the header, and elements as columns of numbers, ASCII or binary."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NoReturn

import numpy as np

from schemas.diagnostics import InvalidInput, Location, finding

_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
_FORMATS: dict[str, Literal["", "<", ">"]] = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_END = re.compile(rb"^end_header[ \t]*(\r\n|\n|\r|\Z)", re.MULTILINE)
_KEYWORDS = frozenset({"format", "comment", "obj_info", "element", "property"})
_TEXTURE_FILE = re.compile(r"TextureFile\s+(.+)", re.IGNORECASE)


@dataclass(frozen=True)
class Property:
    """A column: numpy type of its values without byte order; `count_type` is set for lists."""

    name: str
    type: str
    count_type: str | None = None


@dataclass
class Element:
    """A table announced in the header."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)

    def property(self, name: str) -> Property | None:
        """The property called `name`, if any."""
        return next((p for p in self.properties if p.name == name), None)


@dataclass(frozen=True)
class Header:
    """`order` is the byte order of binary data, empty for ASCII; the data begin at byte `offset`."""

    order: Literal["", "<", ">"]
    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    texture_files: tuple[str, ...]
    offset: int

    def element(self, name: str) -> Element | None:
        """The element called `name`, if any."""
        return next((e for e in self.elements if e.name == name), None)


@dataclass(frozen=True)
class Table:
    """The values of one element: (n,) per scalar property; per list property its values end to end and (n,) counts."""

    scalars: dict[str, np.ndarray]
    lists: dict[str, tuple[np.ndarray, np.ndarray]]


def parse_header(data: bytes, where: Location) -> Header:
    """The header of a PLY file; lines may end in LF, CRLF or CR.

    Raises InvalidInput: `asset/parse-error` with the line, `asset/truncated` when `end_header` never comes.
    """
    if not data.startswith(b"ply"):
        _fail("the file does not begin with 'ply'", 1, where)
    end = _END.search(data.replace(b"\r", b"\n") if b"\n" not in data[:4096] else data)
    if end is None:
        raise InvalidInput(finding("asset/truncated", "the header has no 'end_header'", where=where))
    lines = data[: end.start()].decode("utf-8", "replace").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    order: Literal["", "<", ">"] | None = None
    elements: list[Element] = []
    comments: list[str] = []
    for number, line in enumerate(lines[1:], 2):
        words = line.split()
        in_comment = bool(comments) and comments[-1] == lines[number - 2].strip()
        match words:
            case []:
                continue
            case ["format", name, *_] if name in _FORMATS:
                order = _FORMATS[name]
            case ["comment" | "obj_info", *_]:
                comments.append(line.strip())
            case ["element", name, count] if count.isdecimal() and len(count) < 19:
                elements.append(Element(name, int(count)))
            case ["property", "list", count_type, type_, name] if elements and {count_type, type_} <= _TYPES.keys():
                elements[-1].properties.append(Property(name, _TYPES[type_], _TYPES[count_type]))
            case ["property", type_, name] if elements and type_ in _TYPES:
                elements[-1].properties.append(Property(name, _TYPES[type_]))
            case [word, *_] if in_comment and word not in _KEYWORDS:
                comments.append(line.strip())  # a comment broken over lines, which other readers pass over
            case _:
                _fail(f"'{line.strip()[:60]}' is not a PLY header line", number, where)
        if elements and len({p.name for p in elements[-1].properties}) < len(elements[-1].properties):
            _fail(f"element '{elements[-1].name}' has two properties of one name", number, where)
    if order is None:
        _fail("the header states no format", 1, where)
    textures = tuple(m.group(1).strip() for c in comments if (m := _TEXTURE_FILE.search(c)))
    return Header(order, tuple(elements), tuple(comments), textures, end.end())


def read_tables(header: Header, data: bytes, names: Sequence[str], where: Location) -> dict[str, Table]:
    """The elements named in `names`, by name; reading stops after the last of them.

    Raises InvalidInput: `asset/truncated` when an element announces more rows than the rest of the file can hold
    (checked before any allocation) or the data end early; `asset/parse-error` for a value that is not a number.
    """
    tables: dict[str, Table] = {}
    reader = _Text(data, header.offset, where) if header.order == "" else _Binary(data, header, where)
    for element in header.elements:
        table = reader.read(element) if element.count and element.properties else _empty(element)
        if element.name in names:
            tables[element.name] = table
        if len(tables) == len(set(names)):
            break
    return tables


def _empty(element: Element) -> Table:
    nothing = np.zeros(0)
    return Table(
        {p.name: nothing for p in element.properties if not p.count_type},
        {p.name: (nothing, np.zeros(0, np.int64)) for p in element.properties if p.count_type},
    )


class _Binary:
    def __init__(self, data: bytes, header: Header, where: Location) -> None:
        self._data, self._order, self._at, self._where = data, header.order, header.offset, where

    def read(self, element: Element) -> Table:
        least = sum(np.dtype(p.count_type or p.type).itemsize for p in element.properties)
        _check_room(element, least, len(self._data) - self._at, "bytes", self._where)
        lengths = self._first_lengths(element)
        fields = [
            f
            for p in element.properties
            for f in (
                [(f"#{p.name}", self._order + p.count_type), (p.name, self._order + p.type, (lengths.get(p.name, 0),))]
                if p.count_type
                else [(p.name, self._order + p.type)]
            )
        ]
        row = np.dtype(fields)
        if element.count * row.itemsize <= len(self._data) - self._at:
            rows = np.frombuffer(self._data, row, element.count, self._at)
            if all((rows[f"#{name}"] == length).all() for name, length in lengths.items()):
                self._at += element.count * row.itemsize
                scalars = {p.name: rows[p.name] for p in element.properties if not p.count_type}
                lists = {n: (rows[n].reshape(-1), np.full(element.count, k)) for n, k in lengths.items()}
                return Table(scalars, lists)
        return self._read_ragged(element)

    def _first_lengths(self, element: Element) -> dict[str, int]:
        """How long the lists of the first row are: most files repeat them in every row."""
        at, lengths = self._at, {}
        for p in element.properties:
            if p.count_type:
                lengths[p.name] = self._length(p.count_type, at)
                at += np.dtype(p.count_type).itemsize + lengths[p.name] * np.dtype(p.type).itemsize
            else:
                at += np.dtype(p.type).itemsize
        return lengths

    def _length(self, count_type: str, at: int) -> int:
        dtype = np.dtype(self._order + count_type)
        if at + dtype.itemsize > len(self._data):
            _truncated("the data end inside a row", len(self._data), at, "bytes", self._where)
        length = np.frombuffer(self._data, dtype, 1, at)[0]
        if not 0 <= length <= len(self._data):
            _truncated(f"a list announces {length} values", len(self._data) - at, float(length), "bytes", self._where)
        return int(length)

    def _read_ragged(self, element: Element) -> Table:
        chunks: dict[str, list[bytes]] = {p.name: [] for p in element.properties}
        counts: dict[str, list[int]] = {p.name: [] for p in element.properties if p.count_type}
        columns = [
            (p, np.dtype(p.type).itemsize, np.dtype(p.count_type or p.type).itemsize) for p in element.properties
        ]
        byteorder = "big" if self._order == ">" else "little"
        at, data = self._at, self._data
        for _ in range(element.count):
            for p, size, count_size in columns:
                length = size
                if p.count_type:
                    if p.count_type == "u1" and at < len(data):
                        n = data[at]
                    elif p.count_type[0] == "f":
                        n = self._length(p.count_type, at)
                    else:
                        n = int.from_bytes(data[at : at + count_size], byteorder, signed=p.count_type[0] == "i")
                    if n < 0:
                        _fail("a list has a negative length", None, self._where)
                    counts[p.name].append(n)
                    at += count_size
                    length = n * size
                chunks[p.name].append(data[at : at + length])
                at += length
            if at > len(data):
                _truncated(f"element '{element.name}' ends early", len(data), at, "bytes", self._where)
        self._at = at
        values = {p.name: np.frombuffer(b"".join(chunks[p.name]), self._order + p.type) for p in element.properties}
        lists = {name: (values.pop(name), np.array(c, dtype=np.int64)) for name, c in counts.items()}
        return Table(values, lists)


class _Text:
    def __init__(self, data: bytes, offset: int, where: Location) -> None:
        self._data, self._offset, self._where = data, offset, where
        self._tokens = data[offset:].split()
        self._at = 0

    def read(self, element: Element) -> Table:
        width = len(element.properties)
        _check_room(element, width, len(self._tokens) - self._at, "values", self._where)
        if not any(p.count_type for p in element.properties):
            rows = self._numbers(self._at, self._at + element.count * width).reshape(element.count, width)
            self._at += element.count * width
            return Table({p.name: rows[:, i] for i, p in enumerate(element.properties)}, {})
        return self._read_lists(element)

    def _read_lists(self, element: Element) -> Table:
        picks: dict[str, list[bytes]] = {p.name: [] for p in element.properties}
        counts: dict[str, list[int]] = {p.name: [] for p in element.properties if p.count_type}
        tokens, at = self._tokens, self._at
        for _ in range(element.count):
            for p in element.properties:
                n = 1
                if p.count_type:
                    if at >= len(tokens) or not tokens[at].isdigit():
                        self._fail_token(at, element)
                    n = int(tokens[at])
                    counts[p.name].append(n)
                    at += 1
                picks[p.name] += tokens[at : at + n]
                at += n
            if at > len(tokens):
                _truncated(f"element '{element.name}' ends early", len(tokens), at, "values", self._where)
        begin, self._at = self._at, at
        try:
            values = {name: np.fromiter(map(float, t), np.float64, count=len(t)) for name, t in picks.items()}
        except ValueError:
            self._numbers(begin, at)  # raises with the place
            raise
        lists = {name: (values.pop(name), np.array(c, dtype=np.int64)) for name, c in counts.items()}
        return Table(values, lists)

    def _numbers(self, begin: int, end: int) -> np.ndarray:
        try:
            return np.fromiter(map(float, self._tokens[begin:end]), np.float64, count=end - begin)
        except ValueError:
            pass
        for i in range(begin, end):
            try:
                float(self._tokens[i])
            except ValueError:
                _fail(f"'{self._tokens[i].decode('utf-8', 'replace')}' is not a number", self._line(i), self._where)
        raise AssertionError("called without a bad number")

    def _fail_token(self, at: int, element: Element) -> NoReturn:
        if at >= len(self._tokens):
            _truncated(f"element '{element.name}' ends early", len(self._tokens), at, "values", self._where)
        token = self._tokens[at].decode("utf-8", "replace")
        _fail(f"'{token}' is not the length of a list", self._line(at), self._where)

    def _line(self, token: int) -> int:
        for i, match in enumerate(re.finditer(rb"\S+", self._data[self._offset :])):
            if i == token:
                return self._data.count(b"\n", 0, self._offset + match.start()) + 1
        return self._data.count(b"\n") + 1


def _check_room(element: Element, per_row: int, room: int, unit: str, where: Location) -> None:
    if element.count * per_row > room:
        headline = f"element '{element.name}' announces {element.count} rows"
        _truncated(headline, room, element.count * per_row, unit, where)


def _truncated(headline: str, have: float, need: float, unit: str, where: Location) -> NoReturn:
    raise InvalidInput(
        finding(
            "asset/truncated",
            f"{headline}; {need:.0f} {unit} are needed, {have:.0f} are there",
            where=where,
            value=have,
            bound=need,
            unit=unit,
        )
    )


def _fail(headline: str, line: int | None, where: Location) -> NoReturn:
    raise InvalidInput(finding("asset/parse-error", headline, where=Location(file=where.file, line=line)))
