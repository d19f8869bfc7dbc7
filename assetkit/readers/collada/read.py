"""Reads COLLADA 1.4 and 1.5 (.dae) into a source model.

Source: Khronos, "COLLADA Digital Asset Schema Release 1.4.1" (2008).
Read from the XML itself: pycollada drops whole nodes for a missing material and whole geometries for one comma.
"""

from __future__ import annotations

import math

import numpy as np

from assetkit.readers.collada.geometry import TriangleSet, read_geometry
from assetkit.readers.collada.material import read_material
from assetkit.readers.collada.scene import Placement, read_scene
from assetkit.readers.collada.xml import Document, Element, parse
from assetkit.readers.common.corners import MAX_TRIANGLES, Notes
from assetkit.readers.common.phong import kept_in_record
from assetkit.readers.common.sniff import screen
from assetkit.readers.common.texture_table import TextureTable
from assetkit.sources.source_file import SourceFile
from schemas.appearance.material import Material
from schemas.diagnostics import InvalidInput, Location, Severity, finding
from schemas.evidence import BY_STANDARD, Evidence, declared
from schemas.model import Axis, Mesh, Model, Node
from schemas.outcome import Outcome

_UP: dict[str, Axis] = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}


def read_dae(source: SourceFile) -> Outcome[Model]:
    """The model in a COLLADA file: one mesh per primitive and instance, node transforms applied.

    Unit and up axis are `declared`; where the file leaves them out the standard's own defaults (1 m, y) hold with
    lower confidence. Nothing but image files below the root is ever opened.
    Raises InvalidInput: `asset/parse-error`, `asset/resource-limit`, `asset/path-escape`, `asset/remote-reference`,
    `asset/invalid-unit-value`, `asset/nonfinite-vertices`, `asset/index-out-of-range`, `asset/cyclic-reference`,
    `asset/missing-dependency`, `asset/no-faces`, `asset/empty-geometry`, `asset/wrong-content`, `asset/lfs-pointer`.
    """
    data = source.path.read_bytes()
    where = Location(file=source.relative)
    screen(data, "dae", where=where)
    if not data.strip():
        raise InvalidInput(finding("asset/empty-geometry", "the file is empty", where=where))
    document = parse(data, where)
    meters_per_unit, up_axis = _unit(document), _up_axis(document)
    placements, nodes = read_scene(document)
    textures = TextureTable(source)
    meshes, materials = _meshes(placements, document, textures, source)
    if not meshes:
        _raise_without_faces(document)
    if (animation := document.root.find("library_animations//channel")) is not None:
        headline = "the file is animated; the pose its nodes state was taken"
        document.report(finding("asset/animation-dropped", headline, where=document.place(animation)))
    notes = document.notes + Notes(tuple(textures.diagnostics), tuple(textures.repairs))
    notes += Notes(kept_in_record(materials, where))
    hints, metadata = _texts(document)
    model = Model(
        meshes=meshes,
        materials=materials,
        textures=tuple(textures.textures),
        nodes=_with_meshes(nodes, meshes),
        meters_per_unit=meters_per_unit,
        up_axis=up_axis,
        hints=hints,
        metadata=metadata,
    )
    return Outcome(model, notes.diagnostics, notes.repairs)


def _unit(document: Document) -> Evidence[float]:
    element = document.root.find("asset/unit")
    text = None if element is None else element.get("meter")
    if element is None or text is None:
        return declared(1.0, "COLLADA default unit, 1 m", confidence=BY_STANDARD)
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = math.nan
    place = document.place(element)
    if not (math.isfinite(value) and value > 0.0):
        headline = f"<unit meter='{text}'> is not a positive number"
        raise InvalidInput(finding("asset/invalid-unit-value", headline, where=place, value=text))
    if "," in text:
        headline = f"<unit meter='{text}'> has a decimal comma; it is read as {value:g} m"
        diagnostic = finding("asset/invalid-unit-value", headline, where=place, value=text, severity=Severity.WARNING)
        document.report(diagnostic, "invalid_unit_value", meter=text)
    return declared(value, "COLLADA <unit meter>", inputs=(f"meter={text}",))


def _up_axis(document: Document) -> Evidence[Axis]:
    element = document.root.find("asset/up_axis")
    text = "" if element is None else (element.text or "").strip().upper()
    if text in _UP:
        return declared(_UP[text], "COLLADA <up_axis>")
    if element is not None and text:
        headline = f"<up_axis> is '{text}', not X_UP, Y_UP or Z_UP; y is assumed"
        document.report(finding("asset/invalid-up-axis", headline, where=document.place(element), value=text))
    return declared("y", "COLLADA default up axis, Y_UP", confidence=BY_STANDARD)


def _meshes(
    placements: tuple[Placement, ...], document: Document, textures: TextureTable, source: SourceFile
) -> tuple[tuple[Mesh, ...], tuple[Material, ...]]:
    triangle_sets: dict[Element, tuple[TriangleSet, ...]] = {}
    meshes: list[Mesh] = []
    materials: list[Material] = []
    index: dict[tuple[str, tuple[tuple[str, int], ...]], int] = {}
    triangles = 0
    for placement in placements:
        if placement.geometry not in triangle_sets:
            triangle_sets[placement.geometry] = read_geometry(placement.geometry, document)
        for number, part in enumerate(triangle_sets[placement.geometry]):
            triangles += len(part.triangles)
            if triangles > MAX_TRIANGLES:
                headline = "the instances expand to too many triangles"
                raise InvalidInput(
                    finding(
                        "asset/resource-limit",
                        headline,
                        where=document.where,
                        value=triangles,
                        bound=MAX_TRIANGLES,
                        unit="triangles",
                    )
                )
            material = None
            bound = placement.bindings.get(part.symbol)
            target = part.symbol if bound is None else (bound.get("target") or "").strip().removeprefix("#")
            if target:
                uv_index = {} if bound is None else _uv_index(bound, part)
                key = (target, tuple(sorted(uv_index.items())))
                if key not in index:
                    index[key] = len(materials)
                    materials.append(_material(target, uv_index, document, textures, source))
                material = index[key]
            name = placement.name if number == 0 else f"{placement.name}_{number}"
            meshes.append(_placed(part, placement, name, material))
    return tuple(meshes), tuple(materials)


def _uv_index(bound: Element, part: TriangleSet) -> dict[str, int]:
    """Texture-coordinate names of the effect -> position among the part's UV sets."""
    names = {b.get("semantic") or "": b.get("input_set") or "0" for b in bound.findall("bind_vertex_input")}
    sets = {str(s): i for i, s in enumerate(part.uv_sets)}
    return {name: sets.get(number, 0) for name, number in names.items()}


def _material(
    target: str, uv_index: dict[str, int], document: Document, textures: TextureTable, source: SourceFile
) -> Material:
    """The material `target`; a neutral one of that name where the library lacks it, so that the name is kept."""
    element = document.find(target, "material")
    if element is None:
        headline = f"material '{target}' is not in the file"
        diagnostic = finding(
            "asset/missing-material", headline, where=document.where, value=target, severity=Severity.INFO
        )
        document.report(diagnostic, once=f"material {target}")
        return Material(target)
    name = element.get("name") or target
    return read_material(name, element, uv_index, document, textures, source.path.parent)


def _placed(part: TriangleSet, placement: Placement, name: str, material: int | None) -> Mesh:
    """The part in the frame of the model. A mirroring transform turns the winding back: outside stays so."""
    X = placement.X_WG
    A = X[:3, :3]
    mirrored = float(np.linalg.det(A)) < 0.0
    order = [0, 2, 1] if mirrored else [0, 1, 2]
    return Mesh(
        name=name,
        points=part.points @ A.T + X[:3, 3],
        triangles=part.triangles[:, order],
        normals=None if part.normals is None else _turned(part.normals[:, order], A, mirrored),
        uvs=tuple(uv[:, order] for uv in part.uvs),
        colors=None if part.colors is None else part.colors[:, order],
        material=material,
        source_path=placement.path,
    )


def _turned(normals: np.ndarray, A: np.ndarray, mirrored: bool) -> np.ndarray:
    """Unit normals under the linear map A: by its cofactors, which unlike the inverse exist for flattening maps too."""
    cofactors = np.stack([np.cross(A[1], A[2]), np.cross(A[2], A[0]), np.cross(A[0], A[1])])
    turned = normals.astype(np.float64) @ (-cofactors if mirrored else cofactors).T
    length = np.linalg.norm(turned, axis=2, keepdims=True)
    return np.where(length > 0.0, turned / np.where(length > 0.0, length, 1.0), normals).astype(np.float32)


def _with_meshes(nodes: tuple[Node, ...], meshes: tuple[Mesh, ...]) -> tuple[Node, ...]:
    by_path: dict[str, list[int]] = {}
    for i, mesh in enumerate(meshes):
        by_path.setdefault(mesh.source_path, []).append(i)
    known = tuple(Node(n.path, n.X_PN, tuple(by_path.pop(n.path, ()))) for n in nodes)
    return known + tuple(Node(path, np.eye(4), tuple(indices)) for path, indices in by_path.items())


def _texts(document: Document) -> tuple[tuple[str, ...], dict[str, str]]:
    """Texts that may state units or axes, verbatim; and title, author, copyright and generator."""
    asset = document.root.find("asset")
    if asset is None:
        return (), {}

    def text(path: str) -> str:
        return (asset.findtext(path) or "").strip()

    unit = asset.find("unit")
    name = "" if unit is None else (unit.get("name") or "")
    paths = ("title", "subject", "keywords", "contributor/comments", "contributor/authoring_tool")
    hints = tuple(t for t in (text(p) for p in paths) if t) + ((f"unit name: {name}",) if name else ())
    metadata = {
        "title": text("title"),
        "author": text("contributor/author"),
        "copyright": text("contributor/copyright"),
        "generator": text("contributor/authoring_tool"),
    }
    return hints, {key: value for key, value in metadata.items() if value}


def _raise_without_faces(document: Document) -> None:
    values = sum(1 for a in document.root.iter("float_array") if (a.text or "").strip())
    meshes = sum(1 for _ in document.root.iter("mesh"))
    if meshes and values:
        headline = f"{meshes} meshes, but no primitive with faces"
        raise InvalidInput(finding("asset/no-faces", headline, where=document.where, value=0, bound=1, unit="faces"))
    raise InvalidInput(finding("asset/empty-geometry", "no geometry with points", where=document.where))
