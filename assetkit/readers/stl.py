"""Reads STL files, binary and ASCII, into a source model: one mesh per solid, equal corners joined.

Source: 3D Systems, "Stereolithography Interface Specification" (1988).
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NoReturn

import numpy as np

from assetkit.readers.common.corners import Notes, repaired
from assetkit.readers.common.sniff import screen
from assetkit.readers.source_format import SourceFormat
from assetkit.sources.source_file import SourceFile
from geom.mesh.finite import require_finite
from schemas.diagnostics import InvalidInput, Location, Severity, finding
from schemas.evidence import default
from schemas.model import Mesh, Model, Node
from schemas.outcome import Outcome

HEADER_BYTES = 84  # 80 of free text, then the number of triangles
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_SOLID = re.compile(rb"^[ \t]*solid\b([^\r\n]*)", re.IGNORECASE | re.MULTILINE)
_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)
_KEYWORD = re.compile(rb"\b(vertex|endfacet)\b", re.IGNORECASE)
_END = re.compile(rb"\bend\s*solid\b", re.IGNORECASE)


def read_stl(source: SourceFile) -> Outcome[Model]:
    """The model in an STL file: one mesh per non-empty solid, corners with equal coordinates joined into one point.

    Facet normals are ignored (the corner order decides) and so are the colours some tools hide in header and
    attributes. Unit and up axis are undeclared (`default`). The 80-byte header or the solid names become hints.
    Raises InvalidInput: `asset/truncated`, `asset/empty-geometry`, `asset/nonfinite-vertices`, `asset/parse-error`,
    `asset/wrong-content`, `asset/lfs-pointer`.
    """
    data = source.path.read_bytes()
    where = Location(file=source.relative)
    notes = Notes()
    if _is_binary(data):
        corners, notes = _binary_corners(data, where)
        solids = [(_printable(data[:80]), corners)]
    else:
        screen(data, "stl", where=where)
        solids = _ascii_solids(data, where)
    if not any(len(corners) for _, corners in solids):
        raise InvalidInput(finding("asset/empty-geometry", "the file declares no triangles", where=where))
    meshes = tuple(
        _mesh(name if len(solids) > 1 else "", Path(source.path).stem, corners, i)
        for i, (name, corners) in enumerate((n, c) for n, c in solids if len(c))
    )
    model = Model(
        meshes=meshes,
        materials=(),
        textures=(),
        nodes=tuple(Node(m.source_path, np.eye(4), (i,)) for i, m in enumerate(meshes)),
        meters_per_unit=default(1.0, "STL declares no unit"),
        up_axis=default("z", "STL declares no up axis"),
        hints=tuple(name for name, _ in solids if name),
    )
    return Outcome(model, notes.diagnostics, notes.repairs)


def _is_binary(data: bytes) -> bool:
    """Binary files may begin with "solid" too: the size that the count implies decides, then facet keywords."""
    if len(data) >= HEADER_BYTES and len(data) == HEADER_BYTES + _RECORD.itemsize * _declared(data):
        return True
    if data[:1024].lstrip().lower().startswith(b"solid") and b"\x00" not in data[:1024]:
        return False
    return b"\x00" in data[:1024] and not data.startswith(
        (b"glTF", b"PK\x03\x04", b"PXR-USDC", b"\x89PNG", b"\xff\xd8")
    )


def _declared(data: bytes) -> int:
    return int.from_bytes(data[80:84], "little")


def _binary_corners(data: bytes, where: Location) -> tuple[np.ndarray, Notes]:
    """(m, 3, 3) float64 corners. Where whole triangles follow the declared ones, the count is wrong, not the data:
    streaming writers forget to fill it in. Other trailing bytes are ignored.
    """
    if len(data) < HEADER_BYTES:
        _truncated(len(data), HEADER_BYTES, where)
    count = _declared(data)
    expected = HEADER_BYTES + _RECORD.itemsize * count
    if len(data) < expected:
        _truncated(len(data), expected, where)
    notes = Notes()
    held, rest = divmod(len(data) - HEADER_BYTES, _RECORD.itemsize)
    if held > count and rest == 0:
        headline = f"the header announces {count} triangles, the file holds {held}"
        diagnostic = finding(
            "asset/schema-error", headline, where=where, value=held, bound=count, severity=Severity.WARNING
        )
        notes, count = repaired(diagnostic, "triangle_count", declared=count, held=held), held
    records = np.frombuffer(data, dtype=_RECORD, count=count, offset=HEADER_BYTES)
    with np.errstate(invalid="ignore"):  # signalling NaNs: require_finite names them
        corners = records["corners"].astype(np.float64)
    require_finite(corners.reshape(-1, 3), where, row="corner")
    return corners, notes


def _ascii_solids(data: bytes, where: Location) -> list[tuple[str, np.ndarray]]:
    """(name, (m, 3, 3) float64 corners) of every `solid` section."""
    marks = list(_SOLID.finditer(data))
    if not marks:
        raise InvalidInput(
            finding(
                "asset/parse-error",
                "neither 'solid' nor a binary header begins the file",
                where=Location(file=where.file, line=1, column=1),
            )
        )
    ends = [*(m.start() for m in marks[1:]), len(data)]
    if not _END.search(data, max(0, len(data) - 4096)):
        line = data.count(b"\n") + 1
        raise InvalidInput(
            finding("asset/truncated", "the last 'endsolid' is missing", where=Location(file=where.file, line=line))
        )
    return [
        (_printable(m.group(1)), _ascii_corners(data, m.end(), end, where)) for m, end in zip(marks, ends, strict=True)
    ]


def _ascii_corners(data: bytes, start: int, end: int, where: Location) -> np.ndarray:
    vertices = _VERTEX.findall(data, start, end)
    keywords = [k.lower() for k in _KEYWORD.findall(data, start, end)]
    facets = keywords.count(b"endfacet")
    if len(vertices) != 3 * facets or keywords != [b"vertex", b"vertex", b"vertex", b"endfacet"] * facets:
        _fail_facet(data, start, end, keywords, where)
    try:
        flat = np.fromiter((float(t) for row in vertices for t in row), dtype=np.float64, count=9 * facets)
    except ValueError:
        _fail_number(data, start, end, where)
    points = flat.reshape(-1, 3)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        match = list(_VERTEX.finditer(data, start, end))[bad[0]]
        require_finite(points, _place(data, match.start(), where), row="corner")
    return points.reshape(-1, 3, 3)


def _fail_facet(data: bytes, start: int, end: int, keywords: list[bytes], where: Location) -> NoReturn:
    """Raise for the first facet that has not exactly three readable vertices."""
    cycle = [b"vertex", b"vertex", b"vertex", b"endfacet"]
    wrong = next((i for i, k in enumerate(keywords) if k != cycle[i % 4]), len(keywords) - 1)
    match = list(_KEYWORD.finditer(data, start, end))[max(wrong, 0)]
    raise InvalidInput(
        finding(
            "asset/parse-error",
            "a facet has not exactly three vertices of three numbers",
            where=_place(data, match.start(), where),
        )
    )


def _fail_number(data: bytes, start: int, end: int, where: Location) -> NoReturn:
    for match in _VERTEX.finditer(data, start, end):
        for group in (1, 2, 3):
            try:
                float(match.group(group))
            except ValueError:
                raise InvalidInput(
                    finding(
                        "asset/parse-error",
                        f"'{_printable(match.group(group))}' is not a number",
                        where=_place(data, match.start(group), where),
                    )
                ) from None
    raise AssertionError("called without a bad number")


def _place(data: bytes, offset: int, where: Location) -> Location:
    line_start = data.rfind(b"\n", 0, offset) + 1
    return Location(file=where.file, line=data.count(b"\n", 0, offset) + 1, column=offset - line_start + 1)


def _mesh(name: str, stem: str, corners: np.ndarray, index: int) -> Mesh:
    points, triangles = weld(corners.reshape(-1, 3))
    label = name or stem
    return Mesh(label, points, triangles.reshape(-1, 3), source_path=f"/{label.replace('/', '_')}_{index}")


def weld(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Equal rows of (n, 3) `points` joined: the distinct rows in order of first appearance, (n,) int32 index of each.

    Equality is exact (0.0 equals -0.0): STL repeats every corner, and any tolerance would move geometry.
    """
    order = np.lexsort(points.T)
    fresh = np.ones(len(points), dtype=bool)
    fresh[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    group = np.cumsum(fresh) - 1
    first = np.full(int(group[-1]) + 1, len(points))
    np.minimum.at(first, group, order)
    rank = np.empty_like(first)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first))
    index = np.empty(len(points), dtype=np.int32)
    index[order] = rank[group]
    return np.ascontiguousarray(points[np.sort(first)]), index


def _truncated(size: int, expected: int, where: Location) -> NoReturn:
    raise InvalidInput(
        finding(
            "asset/truncated",
            f"the header announces {expected} bytes, the file has {size}",
            where=where,
            value=size,
            bound=expected,
            unit="bytes",
        )
    )


def _printable(text: bytes) -> str:
    return "".join(c for c in text.decode("latin-1") if c.isascii() and c.isprintable()).strip()


# Binary files begin with free text, so there are no first bytes to know them by.
FORMAT = SourceFormat("stl", (".stl",), read_stl, unit_habit="cad")
