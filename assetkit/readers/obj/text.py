"""Splits the text of an OBJ file into rows of tokens and arrays of numbers, with the line of every row."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np

from schemas.diagnostics import InvalidInput, Location, finding

Key = tuple[str, str, str]  # object, group, material
HINT_LINES = 50


@dataclass
class Faces:
    """Face records in file order: the text after `f`, lines, and the object, group and material in force.

    runs  (first face, index into keys, v, vt and vn counts so far): relative indices count back from there.
    """

    rows: list[bytes] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    empty_lines: list[int] = field(default_factory=list)
    keys: list[Key] = field(default_factory=list)
    runs: list[tuple[int, int, int, int, int]] = field(default_factory=list)

    def key_of_face(self) -> np.ndarray:
        """(f,) index into `keys` of every face."""
        return np.repeat([r[1] for r in self.runs], self._run_lengths())

    def counts_of_face(self) -> np.ndarray:
        """(f, 3) how many v, vt and vn came before every face."""
        return np.repeat(np.array([r[2:] for r in self.runs], dtype=np.int64), self._run_lengths(), axis=0)

    def _run_lengths(self) -> np.ndarray:
        return np.diff([*(r[0] for r in self.runs), len(self.rows)])


@dataclass
class ObjText:
    """Everything `scan` finds. A row is a statement without its keyword."""

    vertices: list[bytes] = field(default_factory=list)
    vertex_lines: list[int] = field(default_factory=list)
    texcoords: list[bytes] = field(default_factory=list)
    texcoord_lines: list[int] = field(default_factory=list)
    normals: list[bytes] = field(default_factory=list)
    normal_lines: list[int] = field(default_factory=list)
    faces: Faces = field(default_factory=Faces)
    libraries: list[tuple[int, str]] = field(default_factory=list)
    material_lines: dict[str, int] = field(default_factory=dict)
    comments: tuple[str, ...] = ()
    other_elements: int = 0
    surface_lines: list[int] = field(default_factory=list)


def scan(data: bytes, where: Location) -> ObjText:
    """Sort the lines of an OBJ file by keyword; unknown statements are passed over, as the format requires.

    Raises InvalidInput `asset/parse-error` when there is text but no line of it is an OBJ statement.
    """
    text = ObjText()
    faces = text.faces
    comments: list[str] = []
    key_index: dict[Key, int] = {}
    object_ = group = material = ""
    changed = True
    unknown_line = 0
    for number, line in enumerate(_lines(data), 1):
        keyword, _, row = line.partition(b" ")
        if keyword not in _COMMON:  # indented, tabbed, or a rarer statement
            words = line.split(None, 1)
            if not words:
                continue
            keyword, row = words[0], words[1] if len(words) == 2 else b""
        if b"#" in line:
            if keyword.startswith(b"#"):
                comments.append(_decoded(line.strip()))
                continue
            row = row if keyword in _NAMES else _TRAILING_COMMENT.sub(b"", row)
        if keyword == b"f" or keyword == b"fo":
            if len(row.split(None, 2)) < 3:
                faces.empty_lines.append(number)
                continue
            if changed:
                index = key_index.setdefault((object_, group, material), len(key_index))
                counts = (len(text.vertices), len(text.texcoords), len(text.normals))
                faces.runs.append((len(faces.rows), index, *counts))
                changed = False
            faces.rows.append(row)
            faces.lines.append(number)
            continue
        changed = True
        if keyword == b"v":
            text.vertices.append(row)
            text.vertex_lines.append(number)
        elif keyword == b"vt":
            text.texcoords.append(row)
            text.texcoord_lines.append(number)
        elif keyword == b"vn":
            text.normals.append(row)
            text.normal_lines.append(number)
        elif keyword == b"g":
            group = _decoded(row.strip())
        elif keyword == b"o":
            object_, group = _decoded(row.strip()), ""
        elif keyword == b"usemtl":
            material = _decoded(row.strip())
            text.material_lines.setdefault(material, number)
        elif keyword == b"mtllib":
            text.libraries.append((number, _decoded(row.strip())))
        elif keyword in {b"p", b"l"}:
            text.other_elements += 1
        elif keyword == b"surf":
            text.surface_lines.append(number)
        elif keyword.lower() not in _PASSED_OVER:
            unknown_line = unknown_line or number
    faces.keys = list(key_index)
    text.comments = tuple(comments[:HINT_LINES])
    if unknown_line and not (text.vertices or faces.rows or text.libraries or text.other_elements):
        _fail("no line of the file is an OBJ statement", unknown_line, 1, where)
    return text


_COMMON = frozenset({b"v", b"vt", b"vn", b"f", b"g", b"o", b"usemtl", b"mtllib", b"s", b"l", b"p"})
_NAMES = frozenset({b"g", b"o", b"usemtl", b"mtllib"})  # may hold a "#"
_TRAILING_COMMENT = re.compile(rb"(^|\s)#.*")
_PASSED_OVER = frozenset(
    b"s vp deg bmat step cstype curv curv2 parm trim hole scrv sp end con mg bevel c_interp d_interp lod "
    b"shadow_obj trace_obj ctech stech maplib usemap call csh".split()
)


def numbers(
    rows: Sequence[bytes], lines: Sequence[int], keyword: str, *, least: int, most: int, where: Location
) -> np.ndarray:
    """(n, w) float64 numbers of the rows after `keyword`, w the widest row but at most `most`; short rows end in 0.

    Raises InvalidInput `asset/parse-error` with line and column for a row that is too short or not numeric.
    """
    if not rows:
        return np.zeros((0, least))
    widths = row_widths(rows)
    if widths.min() < least:
        i = int(np.argmax(widths < least))
        _fail(f"'{_decoded(rows[i].strip())}' holds {widths[i]} numbers, not {least}", lines[i], 1, where)
    width = min(int(widths.max()), most)
    if width == widths.min() == widths.max():
        try:
            values = np.fromiter(map(float, b" ".join(rows).split()), dtype=np.float64, count=len(rows) * width)
            return values.reshape(-1, width)
        except ValueError:
            pass  # the careful way below finds the token
    out = np.zeros((len(rows), width))
    for i, row in enumerate(rows):
        for j, token in enumerate(row.split()[:width]):
            out[i, j] = _number(token, row, lines[i], keyword, where)
    return out


def row_widths(rows: Sequence[bytes]) -> np.ndarray:
    """(n,) tokens per row."""
    return np.fromiter(map(len, map(bytes.split, rows)), dtype=np.int64, count=len(rows))


_MSVC_NAN = re.compile(rb"[+-]?\d\.#\w+")  # "1.#IND", "-1.#QNAN": how old C runtimes print NaN and infinity


def _number(token: bytes, row: bytes, line: int, keyword: str, where: Location) -> float:
    try:
        return float(token)
    except ValueError:
        if _MSVC_NAN.fullmatch(token):
            return float("nan")
        _fail(f"'{_decoded(token)}' is not a number", line, _column(token, row, keyword), where)


def corners(faces: Faces, where: Location) -> tuple[np.ndarray, np.ndarray]:
    """(c, 3) zero-based v, vt, vn index of every corner, vt and vn -1 where absent, and (f,) corners per face.

    Relative (negative) indices are resolved. A v index that names no vertex stays out of range for the caller.
    Raises InvalidInput `asset/parse-error` for corners that are not integers.
    """
    counts = row_widths(faces.rows)
    text = b" ".join(b" ".join(faces.rows).split()) + b" "
    # Slashes per token; then every token as "v", "v vt" or "v vt vn" with 0 for what is left out.
    raw = np.frombuffer(text, dtype=np.uint8)
    slashes = np.diff(np.searchsorted(np.flatnonzero(raw == ord("/")), np.flatnonzero(raw == ord(" "))), prepend=0)
    filled = text.replace(b"//", b"/0/").replace(b"/ ", b"/0 ").replace(b"/", b" ")
    try:
        flat = np.fromiter(map(int, filled.split()), dtype=np.int64)
    except (ValueError, OverflowError):
        flat = np.zeros(0, dtype=np.int64)
    if len(flat) != int((slashes + 1).sum()) or slashes.max(initial=0) > 2:
        _fail_corner(faces, where)
    starts = np.cumsum(slashes + 1) - (slashes + 1)
    out = np.zeros((len(slashes), 3), dtype=np.int64)
    for column in range(3):
        present = slashes >= column
        out[present, column] = flat[starts[present] + column]
    if (out >= 0).all():
        return out - 1, counts
    counted_back = np.repeat(faces.counts_of_face(), counts, axis=0) + out
    counted_back[counted_back < 0] = np.iinfo(np.int64).max  # before the first: out of range, not absent
    return np.where(out < 0, counted_back, out - 1), counts


_CORNER = re.compile(rb"[+-]?\d{1,18}(/([+-]?\d{1,18})?){0,2}")


def _fail_corner(faces: Faces, where: Location) -> NoReturn:
    for row, line in zip(faces.rows, faces.lines, strict=True):
        for token in row.split():
            if not _CORNER.fullmatch(token):
                headline = f"'{_decoded(token)}' is not a face corner (v, v/vt, v//vn or v/vt/vn)"
                _fail(headline, line, _column(token, row, "f"), where)
    _fail("a face corner cannot be read", faces.lines[0], 1, where)


def _column(token: bytes, row: bytes, keyword: str) -> int:
    """1-based column of `token` on a line that is `keyword`, one space, `row`."""
    return len(keyword) + 2 + row.index(token)


def _fail(headline: str, line: int, column: int, where: Location) -> NoReturn:
    raise InvalidInput(
        finding("asset/parse-error", headline, where=Location(file=where.file, line=line, column=column))
    )


def _lines(data: bytes) -> list[bytes]:
    """Physical lines; a line continued by a final backslash is joined to the next, which is left empty."""
    lines = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n").split(b"\n")
    if b"\\" in data:
        for i in range(len(lines) - 2, -1, -1):
            if lines[i].rstrip().endswith(b"\\") and not lines[i].lstrip().startswith(b"#"):
                lines[i], lines[i + 1] = lines[i].rstrip()[:-1] + b" " + lines[i + 1], b""
    return lines


def _decoded(text: bytes) -> str:
    return text.decode("utf-8", "replace")
