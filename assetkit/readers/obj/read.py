"""Reads Wavefront OBJ files into a source model: polygons, groups, materials.

Source: Wavefront "Advanced Visualizer" appendix B1 (OBJ 3.0).
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from assetkit.readers.common.corners import (
    Notes,
    compact,
    empty_faces,
    repaired,
    stray_faces,
    unit_normals,
    usable_colors,
)
from assetkit.readers.common.phong import kept_in_record
from assetkit.readers.common.sniff import as_utf8, screen_text
from assetkit.readers.common.texture_table import TextureTable
from assetkit.readers.obj import text as obj_text
from assetkit.readers.obj.mtl import read_mtl
from assetkit.readers.obj.text import ObjText
from assetkit.sources.source_file import SourceFile
from geom.mesh.finite import require_finite
from geom.mesh.polygon_triangulation import triangulate_polygons
from schemas.appearance.material import Material
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.evidence import default
from schemas.model import Mesh, Model, Node
from schemas.outcome import Outcome

_NO_MATERIAL = frozenset({"", "None", "(null)"})


def read_obj(source: SourceFile) -> Outcome[Model]:
    """The model in an OBJ file: one mesh per (object, group, material), in order of first appearance.

    OBJ declares neither unit nor up axis: both are `default` (1 m, z). Vertex colours are read as display values.
    Raises InvalidInput: `asset/wrong-content`, `asset/lfs-pointer`, `asset/parse-error`, `asset/empty-geometry`,
    `asset/no-faces`, `asset/nonfinite-vertices`, `asset/index-out-of-range` (a tenth of the faces or more),
    `asset/path-escape`, `asset/remote-reference`.
    """
    data = as_utf8(source.path.read_bytes())
    where = Location(file=source.relative)
    screen_text(data, "obj", where=where)
    text = obj_text.scan(data, where)
    if not text.faces.rows:
        _raise_without_faces(text, where)
    points, colors, notes = _points(text, where)
    textures = TextureTable(source)
    materials, used, found = _materials(text, source, textures)
    notes += found
    meshes, found = _meshes(text, points, colors, used, where)
    notes += _left_out(text, where) + found + Notes(tuple(textures.diagnostics), tuple(textures.repairs))
    paths = sorted({m.source_path for m in meshes}, key=[m.source_path for m in meshes].index)
    nodes = tuple(Node(p, np.eye(4), tuple(i for i, m in enumerate(meshes) if m.source_path == p)) for p in paths)
    model = Model(
        meshes=meshes,
        materials=materials,
        textures=tuple(textures.textures),
        nodes=nodes,
        meters_per_unit=default(1.0, "OBJ declares no unit"),
        up_axis=default("z", "OBJ declares no up axis"),
        hints=text.comments,
    )
    return Outcome(model, notes.diagnostics, notes.repairs)


def _raise_without_faces(text: ObjText, where: Location) -> None:
    if text.vertices:
        headline = f"{len(text.vertices)} vertices, {text.other_elements} points or lines, no faces"
        raise InvalidInput(finding("asset/no-faces", headline, where=where, value=0, bound=1, unit="faces"))
    raise InvalidInput(finding("asset/empty-geometry", "no vertices and no faces", where=where))


def _left_out(text: ObjText, where: Location) -> Notes:
    """A remark on points and lines, a warning about curved surfaces."""
    diagnostics: list[Diagnostic] = []
    if text.other_elements:
        headline = f"{text.other_elements} points or lines were left out"
        diagnostics.append(finding("asset/geometry-left-out", headline, where=where, severity=Severity.INFO))
    if text.surface_lines:
        headline = f"{len(text.surface_lines)} curved surfaces (surf) were left out"
        at = where.model_copy(update={"line": text.surface_lines[0]})
        diagnostics.append(finding("asset/geometry-left-out", headline, where=at))
    return Notes(tuple(diagnostics))


def _points(text: ObjText, where: Location) -> tuple[np.ndarray, np.ndarray | None, Notes]:
    """(n, 3) points and (n, 4) linear colours, or None for no colours.

    Rows of 6 or 7 numbers carry a colour (a common extension); rows of 4 a weight, which has no use here.
    """
    rows = obj_text.numbers(text.vertices, text.vertex_lines, "v", least=3, most=7, where=where)
    points = np.ascontiguousarray(rows[:, :3])
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        line = text.vertex_lines[bad[0]]
        require_finite(points, Location(file=where.file, line=line, column=1))
    if rows.shape[1] < 6:
        return points, None, Notes()
    widths = obj_text.row_widths(text.vertices)
    rgba = np.ones((len(points), 4))
    colored = widths >= 6
    rgba[colored, :3] = rows[colored, 3:6]
    if rows.shape[1] == 7:
        rgba[widths >= 7, 3] = rows[widths >= 7, 6]
    if np.nanmax(np.where(np.isfinite(rgba), rgba, 0.0)) > 1.5:
        rgba[:, :3] /= 255.0  # some scanners write bytes
    first = int(np.flatnonzero(~np.isfinite(rgba).all(axis=1))[0]) if not np.isfinite(rgba).all() else 0
    linear, notes = usable_colors(rgba, Location(file=where.file, line=text.vertex_lines[first]))
    return points, linear, notes


def _materials(
    text: ObjText, source: SourceFile, textures: TextureTable
) -> tuple[tuple[Material, ...], dict[str, int], Notes]:
    """The materials that faces use, their index by name, and what is missing.

    Names without a definition become neutral materials, so that the name remains as a clue to the part.
    A file that names no library at all is not at fault for them; one that does is.
    """
    defined: dict[str, Material] = {}
    notes = Notes()
    missing_library = False
    for line, names in text.libraries:
        where = Location(file=source.relative, line=line, column=1)
        paths, absent = _library_paths(names, source, where)
        for path in paths:
            library_materials, read_notes = read_mtl(path, source, textures)
            defined = {**{m.name: m for m in library_materials}, **defined}
            notes += read_notes
        for name in absent:
            missing_library = True
            diagnostic = finding(
                "asset/missing-material", f"material library '{name}' is absent", where=where, value=name
            )
            notes += repaired(diagnostic, "missing_material", library=name)
    materials: list[Material] = []
    index: dict[str, int] = {}
    for name in dict.fromkeys(key[2] for key in text.faces.keys):
        if name in _NO_MATERIAL and name not in defined:
            continue
        if name not in defined and text.libraries and not missing_library:
            where = Location(file=source.relative, line=text.material_lines[name], column=1)
            diagnostic = finding("asset/missing-material", f"material '{name}' is not defined", where=where, value=name)
            notes += repaired(diagnostic, "missing_material", material=name)
        index[name] = len(materials)
        materials.append(defined.get(name, Material(name)))
    notes += Notes(kept_in_record(materials, Location(file=source.relative)))
    return tuple(materials), index, notes


def _library_paths(names: str, source: SourceFile, where: Location) -> tuple[list[Path], list[str]]:
    """The libraries a `mtllib` statement names: one name that may hold spaces, or several names between spaces."""
    if not names:
        return [], []
    words = names.split()
    if len(words) == 1:
        whole = source.resolve(names.strip('"'), where=where)
        return ([whole], []) if whole else ([], [names])
    resolved = [(w, source.resolve(w, where=where)) for w in words]
    whole = source.resolve(names.strip('"'), where=where)
    if whole:
        return [whole], []
    if not any(path for _, path in resolved) and not all(w.lower().endswith(".mtl") for w in words):
        return [], [names]
    return [p for _, p in resolved if p], [w for w, p in resolved if not p]


def _meshes(
    text: ObjText, points: np.ndarray, colors: np.ndarray | None, used: dict[str, int], where: Location
) -> tuple[tuple[Mesh, ...], Notes]:
    faces = text.faces
    empty = faces.empty_lines
    notes = empty_faces(len(empty), Location(file=where.file, line=empty[0], column=1) if empty else where)
    corners, counts = obj_text.corners(faces, where)
    limits = np.array([len(points), len(text.texcoords), len(text.normals)])
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    bad_corner = (corners[:, 0] < 0) | (corners[:, 0] >= limits[0])
    bad = np.add.reduceat(bad_corner, starts) > 0
    first = int(np.flatnonzero(bad)[0]) if bad.any() else 0
    notes += stray_faces(bad, Location(file=where.file, line=faces.lines[first], column=1), points=len(points))
    keep = np.repeat(~bad, counts)
    corners, counts, key_of_face = corners[keep], counts[~bad], np.asarray(faces.key_of_face())[~bad]
    tri_corners, face_of = triangulate_polygons(points, corners[:, 0], counts)
    uvs = obj_text.numbers(text.texcoords, text.texcoord_lines, "vt", least=1, most=3, where=where)
    normals = obj_text.numbers(text.normals, text.normal_lines, "vn", least=3, most=3, where=where)
    notes += _stray_attributes(corners, limits, where)
    key_of_tri = key_of_face[face_of]
    order = np.argsort(key_of_tri, kind="stable")
    meshes: list[Mesh] = []
    bounds = np.searchsorted(key_of_tri[order], np.arange(len(faces.keys) + 1))
    for key, (start, stop) in zip(faces.keys, pairwise(bounds), strict=True):
        if start == stop:
            continue
        picked = corners[tri_corners[order[start:stop]]]  # (m, 3 corners, v/vt/vn)
        mesh, mesh_notes = _mesh(key, picked, points, colors, uvs, normals, used.get(key[2]), where)
        meshes.append(mesh)
        notes += mesh_notes
    return tuple(meshes), notes


def _mesh(
    key: tuple[str, str, str],
    corners: np.ndarray,
    points: np.ndarray,
    colors: np.ndarray | None,
    uvs: np.ndarray,
    normals: np.ndarray,
    material: int | None,
    where: Location,
) -> tuple[Mesh, Notes]:
    triangles, vt, vn = corners[..., 0], corners[..., 1], corners[..., 2]
    notes = Notes()
    corner_uvs: tuple[np.ndarray, ...] = ()
    if (vt >= 0).any() and len(uvs):
        corner_uvs = (_gather(uvs[:, :2], vt, 0.0).astype(np.float32),)
    corner_normals = None
    if (vn >= 0).any() and len(normals):
        corner_normals, notes = unit_normals(_gather(normals, vn, 0.0), points, triangles, where)
    used_points, renumbered = compact(points, triangles)
    path = "/" + "/".join(p.replace("/", "_") for p in key[:2] if p)
    mesh = Mesh(
        name=key[1] or key[0] or Path(where.file or "mesh").stem,
        points=used_points,
        triangles=renumbered,
        normals=corner_normals,
        uvs=corner_uvs,
        colors=None if colors is None else colors[triangles].astype(np.float32),
        material=material,
        source_path=path,
    )
    return mesh, notes


def _gather(values: np.ndarray, index: np.ndarray, missing: float) -> np.ndarray:
    """`values[index]`, with `missing` where the index names no row."""
    valid = (index >= 0) & (index < len(values))
    return np.where(valid[..., None], values[np.where(valid, index, 0)], missing)


def _stray_attributes(corners: np.ndarray, limits: np.ndarray, where: Location) -> Notes:
    """Notes for corners whose vt or vn does not exist; those corners go without."""
    count = int((corners[:, 1:] >= limits[1:]).any(axis=1).sum())
    if count == 0:
        return Notes()
    diagnostic = finding(
        "asset/index-out-of-range",
        f"{count} of {len(corners)} face corners refer to texture coordinates or normals that do not exist",
        where=where,
        value=count,
        bound=0,
        unit="corners",
        severity=Severity.WARNING,
    )
    return repaired(diagnostic, "index_out_of_range", corners=len(corners), bad_corners=count)
