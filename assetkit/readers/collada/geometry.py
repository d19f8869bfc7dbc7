"""COLLADA <geometry> as triangles with corner attributes. Source: COLLADA 1.4.1 specification, chapter 5."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetkit.readers.collada.xml import Document, Element
from assetkit.readers.common.corners import compact, empty_faces, stray_faces, unit_normals
from geom.mesh.finite import require_finite
from geom.mesh.polygon_triangulation import triangulate_polygons, triangulate_with_holes
from schemas.appearance.conversions import srgb_to_linear
from schemas.diagnostics import InvalidInput, Location, Severity, finding

PRIMITIVES = ("triangles", "polylist", "polygons", "tristrips", "trifans")


@dataclass(frozen=True)
class TriangleSet:
    """The triangles of one primitive, in the frame of its geometry; arrays as in `schemas.model.Mesh`."""

    symbol: str  # placeholder of a material until an instance binds it
    points: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None
    uvs: tuple[np.ndarray, ...]
    uv_sets: tuple[int, ...]
    colors: np.ndarray | None


@dataclass(frozen=True)
class _Input:
    semantic: str
    offset: int
    set: int
    values: np.ndarray


def read_geometry(geometry: Element, document: Document) -> tuple[TriangleSet, ...]:
    """The surface primitives of a `geometry` element; lines, splines and empty primitives give nothing.

    Raises InvalidInput: `asset/parse-error` for unreadable positions, `asset/nonfinite-vertices`,
    `asset/index-out-of-range` when a tenth of a primitive's faces or more have no points.
    """
    mesh = geometry.find("mesh")
    if mesh is None:
        for other in geometry.iterchildren("brep", "convex_mesh", "spline"):
            severity = Severity.INFO if other.tag == "spline" else None
            headline = f"<{other.tag}> geometry is not read"
            left_out = finding("asset/geometry-left-out", headline, where=document.place(other), severity=severity)
            document.report(left_out, once=f"{other.tag}")
        return ()
    if (line := next(mesh.iterchildren("lines", "linestrips"), None)) is not None:
        where = document.place(line)
        headline = "lines were left out"
        left_out = finding("asset/geometry-left-out", headline, where=where, severity=Severity.INFO)
        document.report(left_out, once="lines")
    parts = (_read_primitive(p, mesh, document) for p in mesh if p.tag in PRIMITIVES)
    return tuple(p for p in parts if p is not None)


def _read_primitive(primitive: Element, mesh: Element, document: Document) -> TriangleSet | None:
    inputs, width = _inputs(primitive, mesh, document)
    points = next((i.values for i in inputs if i.semantic == "POSITION"), np.zeros((0, 3)))
    position = next((i.offset for i in inputs if i.semantic == "POSITION"), 0)
    where = document.place(primitive)
    try:
        table, counts = _corners(primitive, width, position, points, document)
    except (ValueError, OverflowError):
        _drop(primitive, "its indices cannot be read", document)
        return None
    if len(counts) == 0:
        if _declared_count(primitive) > 0:
            _drop(primitive, "its indices are absent", document)
        return None
    if points.shape[1] < 3:
        points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    points = points[:, :3]
    require_finite(points, where)
    document.notes += empty_faces(int((counts < 3).sum()), where)
    table, counts = _faces(table, counts, counts >= 3)
    corners = table[:, position]
    stray = (
        np.add.reduceat((corners < 0) | (corners >= len(points)), np.cumsum(counts) - counts) > 0
        if len(counts)
        else np.zeros(0, bool)
    )
    document.notes += stray_faces(stray, where, points=len(points))
    table, counts = _faces(table, counts, ~stray)
    if len(counts) == 0:
        return None
    cut, _ = triangulate_polygons(points, table[:, position], counts)
    return _with_attributes(primitive.get("material") or "", points, table[cut], inputs, position, where, document)


def _with_attributes(
    symbol: str,
    points: np.ndarray,
    table: np.ndarray,
    inputs: list[_Input],
    position: int,
    where: Location,
    document: Document,
) -> TriangleSet:
    """The primitive of (m, 3, width) index rows."""
    triangles = table[..., position]
    normals = colors = None
    uvs: dict[int, np.ndarray] = {}
    for i in inputs:
        if len(i.values) == 0:
            continue
        values = _gather(i.values, table[..., i.offset])
        if i.semantic == "NORMAL" and normals is None and values.shape[-1] >= 3:
            normals, notes = unit_normals(values[..., :3], points, triangles, where)
            document.notes += notes
        elif i.semantic == "TEXCOORD" and i.set not in uvs and values.shape[-1] >= 2:
            uvs[i.set] = np.nan_to_num(values[..., :2], nan=0.0, posinf=0.0, neginf=0.0).astype(np.float32)
        elif i.semantic == "COLOR" and colors is None and values.shape[-1] >= 3:
            values = np.where(np.isfinite(values), values, 1.0)
            alpha = np.clip(values[..., 3:4], 0, 1) if values.shape[-1] > 3 else np.ones((*values.shape[:-1], 1))
            colors = np.concatenate([srgb_to_linear(values[..., :3]), alpha], axis=-1).astype(np.float32)
    used, renumbered = compact(points, triangles)
    sets = tuple(sorted(uvs))
    return TriangleSet(symbol, used, renumbered, normals, tuple(uvs[s] for s in sets), sets, colors)


def _inputs(primitive: Element, mesh: Element, document: Document) -> tuple[list[_Input], int]:
    """The inputs of a primitive, those behind VERTEX included, and how many indices one corner has."""
    inputs: list[_Input] = []
    width = 1
    for element in primitive.findall("input"):
        semantic, offset = (element.get("semantic") or "").upper(), _integer(element.get("offset"))
        width = max(width, offset + 1)
        target = _local(mesh, element.get("source"), document)
        if semantic == "VERTEX" and target is not None and target.tag == "vertices":
            for inner in target.findall("input"):
                source = _local(mesh, inner.get("source"), document)
                if source is not None:
                    inner_semantic = (inner.get("semantic") or "").upper()
                    inputs.append(
                        _Input(
                            inner_semantic,
                            offset,
                            _integer(inner.get("set")),
                            _source(source, inner_semantic, document),
                        )
                    )
        elif target is not None and target.tag == "source":
            semantic = "POSITION" if semantic == "VERTEX" else semantic
            values = _source(target, semantic, document)
            inputs.append(_Input(semantic, offset, _integer(element.get("set")), values))
    return inputs, width


def _local(mesh: Element, url: str | None, document: Document) -> Element | None:
    """The element of this mesh that `url` names; ids repeat between meshes in some files, so the mesh goes first."""
    name = (url or "").removeprefix("#")
    return next((e for e in mesh if e.get("id") == name), document.by_id.get(name))


def _source(source: Element, semantic: str, document: Document) -> np.ndarray:
    """(n, k) values of a `source`: the named parameters of its accessor, all columns where none is named."""
    array = source.find("float_array")
    if array is None:
        array = source.find("int_array")
    if array is None:
        return np.zeros((0, 3))
    try:
        values = document.numbers(array)
    except ValueError as error:
        where = document.place(array)
        if semantic == "POSITION":
            raise InvalidInput(
                finding("asset/parse-error", f"a coordinate is unreadable: {error}", where=where)
            ) from None
        headline = f"{semantic} values are unreadable and were dropped: {error}"
        document.report(
            finding("asset/schema-error", headline, where=where, severity=Severity.WARNING), "attribute_dropped"
        )
        return np.zeros((0, 3))
    accessor = source.find("technique_common/accessor")
    if accessor is None:
        stride = 2 if semantic == "TEXCOORD" else 3
        return values[: len(values) // stride * stride].reshape(-1, stride)
    stride = max(_integer(accessor.get("stride"), 1), 1)
    values = values[_integer(accessor.get("offset")) :]
    params = accessor.findall("param")[:stride]
    if stride == 1 and len(params) <= 1 and semantic in {"POSITION", "NORMAL"}:
        stride, params = 3, []  # the accessor is broken; these semantics leave no choice
    rows = values[: len(values) // stride * stride].reshape(-1, stride)
    columns = [i for i, p in enumerate(params) if p.get("name")]
    return rows[:, columns] if len(columns) >= (2 if semantic == "TEXCOORD" else 3) else rows


def _corners(
    primitive: Element, width: int, position: int, points: np.ndarray, document: Document
) -> tuple[np.ndarray, np.ndarray]:
    """(c, width) index rows of all corners and (f,) corners per face. Raises ValueError for unreadable indices."""
    lists = [_rows(p, width) for p in primitive.findall("p")]
    tag = primitive.tag
    if tag == "polygons":
        tables = [rows for rows in lists if len(rows)]
        tables += [r for ph in primitive.findall("ph") for r in _with_holes(ph, width, position, points)]
        counts = np.array([len(t) for t in tables], dtype=np.int64)
        return np.concatenate(tables) if tables else np.zeros((0, width), np.int64), counts
    if tag in {"tristrips", "trifans"}:
        rows = [_strip(r) if tag == "tristrips" else _fan(r) for r in lists if len(r) >= 3]
        table = np.concatenate(rows) if rows else np.zeros((0, width), np.int64)
        return table, np.full(len(table) // 3, 3)
    table = np.concatenate(lists) if lists else np.zeros((0, width), np.int64)
    if tag == "triangles":
        return table[: len(table) // 3 * 3], np.full(len(table) // 3, 3)
    vcount = primitive.find("vcount")
    counts = np.fromiter(map(int, (vcount.text or "").split() if vcount is not None else []), dtype=np.int64)
    if (counts < 0).any():
        raise ValueError("a face has a negative number of corners")
    fits = np.cumsum(counts) <= len(table)
    if fits.any() and not fits.all():
        _drop(primitive, f"its last {int((~fits).sum())} faces have no indices", document)
    return table[: int(counts[fits].sum())], counts[fits]


def _rows(element: Element, width: int) -> np.ndarray:
    flat = np.fromiter(map(int, (element.text or "").split()), dtype=np.int64)
    return flat[: len(flat) // width * width].reshape(-1, width)


def _strip(rows: np.ndarray) -> np.ndarray:
    triangles = np.stack([rows[:-2], rows[1:-1], rows[2:]], axis=1)
    triangles[1::2] = triangles[1::2][:, [1, 0, 2]]
    return triangles.reshape(-1, rows.shape[1])


def _fan(rows: np.ndarray) -> np.ndarray:
    hub = np.broadcast_to(rows[0], rows[2:].shape)
    return np.stack([hub, rows[1:-1], rows[2:]], axis=1).reshape(-1, rows.shape[1])


def _with_holes(ph: Element, width: int, position: int, points: np.ndarray) -> list[np.ndarray]:
    """The triangles, as (3, width) index rows, of one polygon with holes."""
    rings = [_rows(e, width) for e in (*ph.findall("p"), *ph.findall("h"))]
    rings = [r for r in rings if len(r) >= 3]
    if not rings:
        return []
    table = np.concatenate(rings)
    index = table[:, position]
    if index.min() < 0 or index.max() >= len(points) or points.shape[1] < 3 or not np.isfinite(points).all():
        return [table]  # the checks on plain polygons report what is wrong
    return [table[t] for t in triangulate_with_holes([points[r[:, position], :3] for r in rings])]


def _faces(table: np.ndarray, counts: np.ndarray, keep: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return table[np.repeat(keep, counts)], counts[keep]


def _gather(values: np.ndarray, index: np.ndarray) -> np.ndarray:
    """`values[index]`, NaN where the index names no row."""
    if len(values) == 0:
        return np.full((*index.shape, values.shape[1]), np.nan)
    valid = (index >= 0) & (index < len(values))
    return np.where(valid[..., None], values[np.where(valid, index, 0)], np.nan)


def _integer(text: str | None, missing: int = 0) -> int:
    return int(text) if text is not None and text.strip().isdecimal() and len(text) < 10 else missing


def _declared_count(primitive: Element) -> int:
    return _integer(primitive.get("count"))


def _drop(primitive: Element, why: str, document: Document) -> None:
    headline = f"<{primitive.tag}>: {why}"
    diagnostic = finding("asset/schema-error", headline, where=document.place(primitive), severity=Severity.WARNING)
    document.report(diagnostic, "primitive_dropped", primitive=str(primitive.tag))
