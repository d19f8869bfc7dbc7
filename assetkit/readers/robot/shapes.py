"""Surfaces of a description's shapes: primitives as triangles, mesh files by their readers, materials as stated.

Everything comes out in the frame of the model (m), at the rest state that the caller poses the links in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePosixPath

import numpy as np

from assetkit.readers.common.texture_table import TextureTable
from assetkit.readers.robot.materials import stated_material
from assetkit.readers.robot.msh import read_msh
from assetkit.readers.source_format import Reader
from assetkit.sources.source_file import SourceFile
from geom.convex.hull import convex_hull
from geom.mesh import primitives
from geom.pose import matrix_of
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.model import Mesh, Model
from schemas.outcome import Repair
from schemas.robot_description import NOWHERE, DescribedLink, DescribedMaterial, DescribedShape, MeshReference

_VOLUMES = ("box", "sphere", "cylinder", "capsule", "ellipsoid", "mesh")


def usable(shape: DescribedShape) -> bool:
    """Whether a shape has a surface that can be read; planes and height fields are surroundings, not objects."""
    return shape.kind in _VOLUMES and shape.problem is None and (shape.mesh is None or shape.mesh.problem is None)


def visible_shapes(link: DescribedLink) -> list[DescribedShape]:
    """The shapes that show what the link looks like.

    Those that only draw, where there are some; else those that collide. Meshes that are absent count: they are missed.
    Shapes without a size show nothing.
    """
    drawn = [s for s in link.shapes if s.drawn and s.kind in (*_VOLUMES, "unknown", "fitted") and not _is_empty(s)]
    only_drawn = [s for s in drawn if not s.collides]
    return only_drawn or drawn or [s for s in link.shapes if usable(s)]


def _is_empty(shape: DescribedShape) -> bool:
    return shape.problem is not None and shape.problem.code == "robot/invalid-size"


@dataclass
class SurfaceReader:
    """Reads the shapes of one description; each mesh file is read once. Materials and textures are those of all."""

    source: SourceFile
    readers: Mapping[str, Reader]
    mesh_materials_count: bool  # URDF: a mesh file may bring its of_file materials; MuJoCo ignores them
    materials: list[Material] = field(default_factory=list[Material])
    diagnostics: list[Diagnostic] = field(default_factory=list[Diagnostic])
    repairs: list[Repair] = field(default_factory=list[Repair])
    _files: dict[str, tuple[Model, int]] = field(default_factory=dict[str, tuple[Model, int]])
    _textures: dict[str, Texture] = field(default_factory=dict[str, Texture])
    _described: dict[DescribedMaterial, int] = field(default_factory=dict[DescribedMaterial, int])

    def __post_init__(self) -> None:
        self._table = TextureTable(self.source)

    @property
    def textures(self) -> tuple[Texture, ...]:
        """All textures, under unique names."""
        return tuple(self._textures.values())

    def finish(self) -> None:
        """Take over what the stated textures led to."""
        self.diagnostics += self._table.diagnostics
        self.repairs += self._table.repairs

    def surfaces(self, shape: DescribedShape, X_MS: FloatArray, name: str, path: str, turn: FloatArray) -> list[Mesh]:
        """The meshes of a shape at X_MS (4, 4); `turn` (3, 3) comes first, for files whose axes the caller corrects.

        Raises InvalidInput as the readers of meshes do, and the shape's of_file problem.
        """
        if shape.mesh is not None and shape.mesh.problem is not None:
            raise InvalidInput(shape.mesh.problem)
        if shape.problem is not None or shape.kind not in _VOLUMES:
            raise InvalidInput(shape.problem or _unsupported(shape))
        if shape.mesh is None:
            tessellation = _primitive(shape)
            mesh = Mesh(name, tessellation.points, tessellation.triangles.astype(np.int32), source_path=path)
            stated = self._material(shape.material, textured=False)
            return [replace(_mapped(mesh, X_MS[:3, :3], X_MS[:3, 3]), material=stated)]
        linear, shift = _frame_of(shape.mesh)
        linear, shift = X_MS[:3, :3] @ linear @ turn, X_MS[:3, :3] @ shift + X_MS[:3, 3]
        return [
            replace(
                _mapped(mesh, linear, shift),
                name=f"{name}_{index}" if index else name,
                source_path=f"{path}/{index}",
                material=self._chosen(mesh, shape.material),
            )
            for index, mesh in enumerate(self.meshes_of(shape.mesh))
        ]

    def meshes_of(self, reference: MeshReference) -> tuple[Mesh, ...]:
        """The meshes of a file in metres, with indices into `materials`; or those written in the description."""
        if reference.vertices is not None:
            points = reference.vertices
            triangles = reference.triangles
            if triangles is None:  # MuJoCo takes the convex hull of vertices without faces.
                points, triangles = convex_hull(points)
            return (Mesh(reference.name, points, triangles.astype(np.int32)),)
        if reference.path not in self._files:
            self._files[reference.path] = self._read(reference)
        model, first = self._files[reference.path]
        scale = model.meters_per_unit.value if model.meters_per_unit.source == "declared" else 1.0
        return tuple(
            replace(mesh, points=mesh.points * scale, material=None if mesh.material is None else mesh.material + first)
            for mesh in model.meshes
            if len(mesh.triangles)
        )

    def _read(self, reference: MeshReference) -> tuple[Model, int]:
        path = self.source.root / reference.path
        suffix = path.suffix.lower()
        read = read_msh if suffix == ".msh" else self.readers.get(suffix)
        if read is None:
            headline = f"mesh '{reference.uri[:200]}' is of a kind that is not read"
            raise InvalidInput(
                finding("asset/format-unsupported", headline, where=reference.source.location, value=suffix)
            )
        self.source.visited.add(path.resolve())
        outcome = read(SourceFile(path, self.source.root, self.source.visited, self.source.missing))
        self.diagnostics += outcome.diagnostics
        self.repairs += outcome.repairs
        if outcome.value is None:
            raise InvalidInput(outcome.diagnostics[0])
        first = len(self.materials)
        names = {t.name: self._add_texture(t) for t in outcome.value.textures}
        self.materials += [_with_textures(m, names) for m in outcome.value.materials]
        return outcome.value, first

    def _add_texture(self, texture: Texture) -> str:
        """The texture's unique name; equal bytes under equal names are one texture."""
        name, count = texture.name, 1
        while name in self._textures and self._textures[name].data != texture.data:
            count += 1
            name = f"{texture.name}_{count}"
        self._textures[name] = replace(texture, name=name)
        return name

    def _material(self, described: DescribedMaterial | None, *, textured: bool) -> int | None:
        """The index of a stated material; None where nothing is stated.

        Without texture coordinates (not `textured`) its texture is left out: MuJoCo wraps such meshes in a cube.
        """
        if described is None or (described.rgba is None and not described.texture):
            return None
        key = replace(described, source=NOWHERE)  # Equal statements are one material.
        key = key if textured else replace(key, texture="")
        if key not in self._described:
            self._described[key] = len(self.materials)
            use_of = partial(self._stated_texture, described) if textured else _no_texture
            material = stated_material(described, use_of)
            self.materials.append(material)
            if material.unmapped:
                headline = f"material '{material.name}': {', '.join(material.unmapped)} kept in the record only"
                where = described.source.location
                self.diagnostics.append(finding("asset/material-extension-fallback", headline, where=where))
        return self._described[key]

    def _stated_texture(self, described: DescribedMaterial, uri: str) -> TextureUse | None:
        folder = (self.source.root / described.source.file).parent if described.source.file else self.source.path.parent
        if uri.startswith("package://"):
            uri = PurePosixPath(uri).name
        name = self._table.add(uri, base=folder, where=described.source.location)
        if name is None:
            return None
        return TextureUse(self._add_texture(self._table.get(name)))

    def _chosen(self, mesh: Mesh, described: DescribedMaterial | None) -> int | None:
        """A stated material replaces that of the file, unless the file has a texture and the statement has none."""
        stated = self._material(described, textured=bool(mesh.uvs))
        of_file = mesh.material if self.mesh_materials_count else None
        if of_file is None or stated is None:
            return of_file if stated is None else stated
        textured = self.materials[of_file].base_color_texture is not None
        return of_file if textured and described is not None and not described.texture else stated


def _no_texture(_: str) -> TextureUse | None:
    """The surface has no texture coordinates."""
    return None


def _with_textures(material: Material, names: Mapping[str, str]) -> Material:
    """The material with its textures under their new names."""
    for name, use in material.texture_uses.items():
        if names.get(use.texture, use.texture) != use.texture:
            material = material.with_value(name, replace(use, texture=names[use.texture]))
    return material


def _primitive(shape: DescribedShape) -> primitives.Tessellation:
    if shape.kind == "box":
        cube = primitives.cube(1.0)
        return primitives.Tessellation(cube.points * np.array(shape.size_m), cube.triangles, cube.normals)
    if shape.kind == "sphere":
        return primitives.sphere(shape.size_m[0])
    if shape.kind == "ellipsoid":
        ball = primitives.sphere(1.0)
        return primitives.Tessellation(ball.points * np.array(shape.size_m), ball.triangles, ball.normals)
    radius, height = shape.size_m
    make = primitives.cylinder if shape.kind == "cylinder" else primitives.capsule
    return make(height, radius, radius)


def _frame_of(mesh: MeshReference) -> tuple[FloatArray, FloatArray]:
    """Linear map (3, 3) and shift (3,) from the file to the shape: scale * R^T (v - p)."""
    linear = np.diag(mesh.scale) @ matrix_of(np.array(mesh.reference_quat_wxyz)).T
    return linear, -linear @ np.array(mesh.reference_position_m)


def _mapped(mesh: Mesh, linear: FloatArray, shift: FloatArray) -> Mesh:
    """The mesh under p -> linear p + shift; a map that mirrors turns the corner order round."""
    determinant = float(np.linalg.det(linear))
    normals = mesh.normals
    if normals is not None:
        turned = normals.astype(np.float64) @ np.linalg.inv(linear) if determinant else normals
        length = np.linalg.norm(turned, axis=2, keepdims=True)
        normals = (turned / np.where(length > 0.0, length, 1.0)).astype(np.float32)
    mapped = replace(mesh, points=mesh.points @ linear.T + shift, normals=normals)
    if determinant >= 0.0:
        return mapped
    flipped = np.array([0, 2, 1])
    return replace(
        mapped,
        triangles=mapped.triangles[:, flipped],
        normals=None if normals is None else normals[:, flipped],
        uvs=tuple(uv[:, flipped] for uv in mapped.uvs),
        colors=None if mapped.colors is None else mapped.colors[:, flipped],
    )


def _unsupported(shape: DescribedShape) -> Diagnostic:
    return finding("robot/unsupported-shape", f"a shape of kind '{shape.kind}'", where=shape.source.location)


def shape_name(shape: DescribedShape, link: str, shapes: Sequence[DescribedShape]) -> str:
    """A name for the meshes of a shape: its own, that of its mesh, else that of its link."""
    if shape.name:
        return shape.name
    if shape.mesh is not None and (shape.mesh.name or shape.mesh.uri):
        return shape.mesh.name or Path(shape.mesh.uri.replace("\\", "/")).stem
    return link if len(shapes) == 1 else f"{link}_{shape.kind}"
