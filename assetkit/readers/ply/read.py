"""Reads PLY files into a source model: triangles, polygons, colours, texture coordinates.

Source: Greg Turk, "The PLY Polygon File Format" (1994).
"""

from __future__ import annotations

import numpy as np

from assetkit.readers.common.corners import Notes, compact, empty_faces, stray_faces, unit_normals, usable_colors
from assetkit.readers.common.sniff import screen
from assetkit.readers.common.texture_table import TextureTable
from assetkit.readers.ply.container import Element, Header, Table, parse_header, read_tables
from assetkit.sources.source_file import SourceFile
from geom.mesh.finite import require_finite
from geom.mesh.polygon_triangulation import triangulate_polygons
from schemas.appearance.material import Material, Origin, TextureUse
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.evidence import default
from schemas.model import Mesh, Model, Node
from schemas.outcome import Outcome

_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
_COLOR_NAMES = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
_ALPHA_NAMES = ("alpha", "a", "diffuse_alpha")
_CORNER_LISTS = ("vertex_indices", "vertex_index")


def read_ply(source: SourceFile) -> Outcome[Model]:
    """The model in a PLY file: one mesh, or one per texture file where faces carry a texture number.

    Vertex colours (else face colours) are read as display values. Unit and up axis are undeclared (`default`);
    comments and obj_info lines become hints. Counts are held against the file size before anything is allocated.
    Raises InvalidInput: `asset/parse-error`, `asset/schema-error`, `asset/truncated`, `asset/no-faces`,
    `asset/empty-geometry`, `asset/nonfinite-vertices`, `asset/index-out-of-range`, `asset/wrong-content`,
    `asset/lfs-pointer`, `asset/path-escape`, `asset/remote-reference`.
    """
    data = source.path.read_bytes()
    where = Location(file=source.relative)
    screen(data, "ply", where=where)
    header = parse_header(data, where)
    vertex, face = _elements(header, where)
    tables = read_tables(header, data, (vertex.name, face.name), where)
    textures = TextureTable(source)
    materials = _materials(header, textures, source, where)
    meshes, notes = _meshes(vertex, face, tables, source.path.stem, len(materials), where)
    notes += Notes(tuple(textures.diagnostics), tuple(textures.repairs))
    model = Model(
        meshes=meshes,
        materials=materials,
        textures=tuple(textures.textures),
        nodes=(Node(f"/{source.path.stem}", np.eye(4), tuple(range(len(meshes)))),),
        meters_per_unit=default(1.0, "PLY declares no unit"),
        up_axis=default("z", "PLY declares no up axis"),
        hints=header.comments,
    )
    return Outcome(model, notes.diagnostics, notes.repairs)


def _elements(header: Header, where: Location) -> tuple[Element, Element]:
    """The vertex element and the one that holds faces (`face`, or `tristrips`); raises where they hold nothing."""
    vertex = header.element("vertex")
    if vertex is None or vertex.count == 0:
        raise InvalidInput(finding("asset/empty-geometry", "the header announces no vertices", where=where))
    candidates = (header.element("face"), header.element("tristrips"))
    face = next((e for e in candidates if e and e.count and _corner_list(e)), None)
    if face is None:
        headline = f"{vertex.count} vertices and no list of faces"
        raise InvalidInput(finding("asset/no-faces", headline, where=where, value=0, bound=1, unit="faces"))
    for axis in "xyz":
        column = vertex.property(axis)
        if column is None or column.count_type:
            raise InvalidInput(finding("asset/schema-error", f"vertices have no scalar property '{axis}'", where=where))
    return vertex, face


def _corner_list(element: Element) -> str | None:
    return next((n for n in _CORNER_LISTS if (p := element.property(n)) and p.count_type), None)


def _materials(header: Header, textures: TextureTable, source: SourceFile, where: Location) -> tuple[Material, ...]:
    """One white material per `comment TextureFile`; neutral where the picture is absent."""
    materials: list[Material] = []
    for file in header.texture_files:
        name = textures.add(file, base=source.path.parent, where=where)
        materials.append(_textured(file, name) if name else Material(file))
    return tuple(materials)


def _textured(file: str, texture: str) -> Material:
    origin = Origin("declared", "comment TextureFile")
    return Material(
        file,
        base_color=(1.0, 1.0, 1.0),
        base_color_texture=TextureUse(texture),
        origins={"base_color": origin, "base_color_texture": origin},
    )


def _meshes(
    vertex: Element, face: Element, tables: dict[str, Table], name: str, materials: int, where: Location
) -> tuple[tuple[Mesh, ...], Notes]:
    vertices, faces = tables[vertex.name], tables[face.name]
    points = np.stack([vertices.scalars[axis] for axis in "xyz"], axis=1).astype(np.float64)
    require_finite(points, where)
    flat, counts = faces.lists[_corner_list(face) or ""]
    corners = _whole(flat)
    if face.name == "tristrips":
        corners, counts = _unrolled(corners, counts)
    starts = np.cumsum(counts) - counts
    notes = empty_faces(int((counts < 3).sum()), where)
    wrong = (corners < 0) | (corners >= len(points))
    running = np.concatenate([[0], np.cumsum(wrong)])
    stray = (running[starts + counts] > running[starts]) & (counts >= 3)
    notes += stray_faces(stray, where, points=len(points))
    good = np.flatnonzero((counts >= 3) & ~stray)
    if len(good) == 0:
        raise InvalidInput(finding("asset/no-faces", "no face has three corners", where=where, value=0, bound=1))
    position = np.flatnonzero(np.repeat(np.isin(np.arange(len(counts)), good), counts))
    cut, owner = triangulate_polygons(points, corners[position], counts[good])
    triangles, face_of = corners[position][cut], good[owner]
    normals, found = _normals(vertices, points, triangles, where)
    notes += found
    colors, found = _colors(vertex, face, vertices, faces, triangles, face_of, where)
    notes += found
    uvs = _uvs(vertices, faces, triangles, position[cut], starts, counts, face_of)
    group = _texture_numbers(faces, face_of, materials)
    meshes: list[Mesh] = []
    for number in np.unique(group):
        chosen = group == number
        used, renumbered = compact(points, triangles[chosen])
        meshes.append(
            Mesh(
                name=name if len(meshes) == 0 else f"{name}_{number}",
                points=used,
                triangles=renumbered,
                normals=None if normals is None else normals[chosen],
                uvs=() if uvs is None else (uvs[chosen],),
                colors=None if colors is None else colors[chosen],
                material=int(number) if materials else None,
                source_path=f"/{name}",
            )
        )
    return tuple(meshes), notes


def _whole(values: np.ndarray) -> np.ndarray:
    """Indices as int64; values that are no whole number become -1."""
    if values.dtype.kind in "iu":
        return values.astype(np.int64)
    whole = np.isfinite(values) & (np.abs(values) < 2**53) & (np.floor(values) == values)
    return np.where(whole, np.where(whole, values, 0), -1).astype(np.int64)


def _unrolled(corners: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangle strips, separated by -1, as corners and counts of triangles; every second one is turned back.

    Triangles with a repeated corner only stitch strips together and are left out.
    """
    ends = np.zeros(len(corners) + 1, dtype=bool)
    ends[np.cumsum(counts)] = True
    strip_ends = np.flatnonzero(ends[1:]) + 1
    triangles: list[np.ndarray] = []
    for strip in np.split(corners, strip_ends[:-1]):
        for run in np.split(strip, np.flatnonzero(strip == -1)):
            run = run[run != -1]
            if len(run) >= 3:
                t = np.stack([run[:-2], run[1:-1], run[2:]], axis=1)
                t[1::2] = t[1::2, [1, 0, 2]]
                triangles.append(t)
    every = np.concatenate(triangles) if triangles else np.zeros((0, 3), np.int64)
    distinct = every[(every[:, 0] != every[:, 1]) & (every[:, 1] != every[:, 2]) & (every[:, 0] != every[:, 2])]
    return distinct.reshape(-1), np.full(len(distinct), 3)


def _normals(
    vertices: Table, points: np.ndarray, triangles: np.ndarray, where: Location
) -> tuple[np.ndarray | None, Notes]:
    if not {"nx", "ny", "nz"} <= vertices.scalars.keys():
        return None, Notes()
    normals = np.stack([vertices.scalars[n] for n in ("nx", "ny", "nz")], axis=1).astype(np.float64)
    if not normals[triangles].any():
        return None, Notes()  # MeshLab writes zeros for "none"
    return unit_normals(normals[triangles], points, triangles, where)


def _colors(
    vertex: Element,
    face: Element,
    vertices: Table,
    faces: Table,
    triangles: np.ndarray,
    face_of: np.ndarray,
    where: Location,
) -> tuple[np.ndarray | None, Notes]:
    """(m, 3, 4) float32 linear corner colours, from the vertices or else from the faces."""
    for element, table, index in ((vertex, vertices, triangles), (face, faces, np.repeat(face_of[:, None], 3, axis=1))):
        names = next((n for n in _COLOR_NAMES if set(n) <= table.scalars.keys()), None)
        if names is None or (element.name == "tristrips"):
            continue
        alpha = next((n for n in _ALPHA_NAMES if n in table.scalars), None)
        columns = [_share(element, table, n) for n in (*names, *((alpha,) if alpha else ()))]
        rgba = np.stack([*columns, *([] if alpha else [np.ones(len(columns[0]))])], axis=1)
        linear, notes = usable_colors(rgba, where)
        return linear[index].astype(np.float32), notes
    return None, Notes()


def _share(element: Element, table: Table, name: str) -> np.ndarray:
    """A colour column scaled to 0..1: integer types by their range, floats by 255 where they exceed 1."""
    column = element.property(name)
    values = table.scalars[name].astype(np.float64)
    if column and column.type[0] in "iu":
        return values / np.iinfo(column.type).max
    return values / 255.0 if np.max(values, initial=0.0, where=np.isfinite(values)) > 1.5 else values


def _uvs(
    vertices: Table,
    faces: Table,
    triangles: np.ndarray,
    positions: np.ndarray,
    starts: np.ndarray,
    counts: np.ndarray,
    face_of: np.ndarray,
) -> np.ndarray | None:
    """(m, 3, 2) float32: per corner from the face list `texcoord`, else from the vertices; v points up in PLY.

    positions  (m, 3) places of the corners in the flat corner list; a face whose list has another length gets zeros.
    """
    if "texcoord" in faces.lists and len(counts) == len(faces.lists["texcoord"][1]):
        values, lengths = faces.lists["texcoord"]
        offset = (np.cumsum(lengths) - lengths)[face_of, None] + 2 * (positions - starts[face_of, None])
        fits = (lengths == 2 * counts)[face_of]
        if fits.any():
            place = np.where(fits[:, None], offset, 0)
            uvs = np.stack([values[place], values[place + 1]], axis=2)
            return np.where(fits[:, None, None] & np.isfinite(uvs), uvs, 0.0).astype(np.float32)
    names = next((n for n in _UV_NAMES if set(n) <= vertices.scalars.keys()), None)
    if names is None:
        return None
    uv = np.stack([vertices.scalars[n] for n in names], axis=1).astype(np.float32)
    return np.where(np.isfinite(uv), uv, np.float32(0.0))[triangles]


def _texture_numbers(faces: Table, face_of: np.ndarray, materials: int) -> np.ndarray:
    """(m,) index of the texture file of each triangle; numbers out of range mean the first."""
    if "texnumber" not in faces.scalars or materials < 2:
        return np.zeros(len(face_of), dtype=np.int64)
    numbers = _whole(faces.scalars["texnumber"])[face_of]
    return np.where((numbers >= 0) & (numbers < materials), numbers, 0)
