"""Mesh and material assets of an MJCF model by name, mesh files found inside the root."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import numpy as np

from formats.attributes import Attributes, number, numbers, vector
from formats.mesh_files import mesh_file
from formats.mjcf.defaults import Defaults
from formats.mjcf.settings import CompilerSettings, asset_name
from formats.xml_elements import Element, refuse
from schemas.diagnostics import Diagnostic, Severity, finding
from schemas.robot_description import DescribedMaterial, MeshReference, SourceLine

_SHARES = ("metallic", "roughness", "specular", "shininess", "emission")
# MuJoCo places 2d textures without texture coordinates by these; reflectance is a mirror image in planes and boxes.
_NOT_READ = ("texrepeat", "texuniform", "reflectance")
_ONE, _ZERO, _IDENTITY = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)


class Assets:
    """`meshes` and `materials` by name. `unread` are elements of `<asset>` of other kinds, `notes` the findings."""

    def __init__(self, top: Element, defaults: Defaults, settings: CompilerSettings, folder: Path, root: Path) -> None:
        self.defaults, self.settings, self.folder, self.root = defaults, settings, folder, root
        self.meshes: dict[str, MeshReference] = {}
        self.materials: dict[str, DescribedMaterial] = {}
        self.unread: list[Element] = []
        self.notes: list[Diagnostic] = []
        self._textures: dict[str, str] = {}
        elements = [child for section in top.named("asset") for child in section.children]
        for element in elements:
            if element.tag == "texture":
                self._texture(element)
        for element in elements:
            if element.tag == "mesh":
                mesh = self._mesh(element)
                if mesh.name in self.meshes:
                    refuse("robot/duplicate-name", f"two meshes are called '{mesh.name}'", element.source, mesh.name)
                self.meshes[mesh.name] = mesh
            elif element.tag == "material":
                self._material(element)
            elif element.tag != "texture":
                self.unread.append(element)

    def _texture(self, element: Element) -> None:
        file = asset_name(element.get("file"), self.settings.texture_folder, self.settings.strip_folders)
        name = element.get("name") or PurePosixPath(file).stem
        self._note_twice(name, self._textures, element)
        self._textures.setdefault(name, file)

    def _material(self, element: Element) -> None:
        a, name = self.defaults.attributes(element, ""), element.get("name")
        self._note_twice(name, self.materials, element)
        red, green, blue, opacity = numbers(a, "rgba", 4, (1.0,) * 4, element.source)
        layers = {layer.get("role"): self._textures.get(layer.get("texture"), "") for layer in element.named("layer")}
        color_map = a.get("texture", "")
        texture = self._textures.get(color_map) or layers.pop("rgb", "") or layers.pop("rgba", "")
        unread = [(key, a[key]) for key in _NOT_READ if key in a]
        if color_map in self._textures and not self._textures[color_map]:
            unread.append(("texture", f"{color_map}, which has no file"))  # drawn by MuJoCo, or a cube map
        material = DescribedMaterial(
            name,
            (red, green, blue, opacity),
            texture,
            element.source,
            **{key: _share(a, key, element.source) for key in _SHARES},
            layers=tuple((role, file) for role, file in layers.items() if file),
            unread=tuple(unread),
        )
        self.materials.setdefault(name, material)

    def _note_twice(self, name: str, known: dict[str, str] | dict[str, DescribedMaterial], element: Element) -> None:
        if name in known:
            headline = f"two elements <{element.tag}> are called '{name}'; the first one counts"
            self.notes.append(
                finding(
                    "robot/duplicate-name",
                    headline,
                    where=element.source.location,
                    value=name,
                    severity=Severity.WARNING,
                )
            )

    def _mesh(self, element: Element) -> MeshReference:
        a, source = self.defaults.attributes(element, ""), element.source
        uri = asset_name(a.get("file", ""), self.settings.mesh_folder, self.settings.strip_folders)
        name = a.get("name") or PurePosixPath(uri).stem
        if not name:
            refuse("robot/missing-name", "a <mesh> has neither name nor file", source)
        vertices = triangles = None
        if not uri and "vertex" in a:
            vertices = np.array(numbers(a, "vertex", None, None, source))
            if vertices.size % 3:
                refuse("robot/invalid-number", f"mesh '{name}' has {vertices.size} coordinates", source, vertices.size)
            vertices = vertices.reshape(-1, 3)
            faces = np.array(numbers(a, "face", None, (), source), dtype=np.float64)
            if faces.size % 3 or (faces.size and not (faces.min() >= 0 and faces.max() < len(vertices))):
                refuse("robot/invalid-number", f"the faces of mesh '{name}' do not fit its vertices", source, name)
            triangles = faces.astype(np.int64).reshape(-1, 3) if faces.size else None
        path, problem = "", None
        if uri:
            path, problem = mesh_file(uri, self.folder, self.root, source)
        elif vertices is None:
            headline = f"mesh '{name}' has neither a file nor vertices"
            problem = finding("robot/unsupported-shape", headline, where=source.location, value=name)
        self.notes += [] if problem is None else [problem]
        w, x, y, z = numbers(a, "refquat", 4, _IDENTITY, source)
        return MeshReference(
            uri,
            path,
            vector(a, "scale", _ONE, source),
            vector(a, "refpos", _ZERO, source),
            (w, x, y, z),
            vertices,
            triangles,
            name,
            problem,
            source,
        )


def _share(a: Attributes, key: str, source: SourceLine) -> float | None:
    """A number that MuJoCo takes for unstated where it is negative."""
    value = number(a, key, -1.0, source)
    return value if value >= 0.0 else None
