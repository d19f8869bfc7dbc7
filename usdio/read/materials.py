"""Converts UsdShade materials of gprims into `schemas.appearance.material.Material`, with the textures they use."""

from __future__ import annotations

import posixpath
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from pxr import Usd, UsdShade

from schemas.appearance.material import Material, Texture
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.files.references import tile_references
from schemas.outcome import INTAKE, Repair
from usdio.read.layer_guard import PinnedLayers
from usdio.read.pbr import Color, MaterialConversion, layer_sources, with_layers_of
from usdio.read.shader_dialects import DIALECTS, PREVIEW, ShaderDialect, dialect_of, is_known
from usdio.read.shader_graph import (
    EARLIEST,
    ImageSource,
    InputSource,
    PrimvarSource,
    input_source,
    shader_identifier,
    source_node,
    to_json,
)

LoadTexture = Callable[..., tuple[Texture | None, tuple[Diagnostic, ...]]]


@dataclass(frozen=True)
class ConvertedMaterial:
    """One converted material.

    `uv_names` are the primvars its textures read, in the order of `TextureUse.uv_set`; `shows_mesh_colors` is
    true when its colour comes from the mesh; `source_name` is the name of the material prim.
    """

    material: Material
    uv_names: tuple[str, ...] = ()
    shows_mesh_colors: bool = False
    source_name: str = ""


class MaterialTable:
    """The materials and textures of one stage while it is being read: each is converted once.

    `entries`, `textures`, `diagnostics` and `repairs` grow as `add` is called.
    """

    def __init__(self, layers: PinnedLayers, load_texture: LoadTexture) -> None:
        self._layers = layers
        self._load_texture = load_texture
        self._known: dict[tuple[str, Color | None, bool], int] = {}
        self._dangling: set[str] = set()
        self._texture_names: dict[str, str | None] = {}
        self.entries: list[ConvertedMaterial] = []
        self.textures: list[Texture] = []
        self.diagnostics: list[Diagnostic] = []
        self.repairs: list[Repair] = []

    def add(self, prim: Usd.Prim, color: Color | None, *, double_sided: bool) -> int | None:
        """The index of the material bound to `prim`, or of a plain one in the mesh's constant display `color`.

        None when nothing is bound and no colour is given.
        """
        source = bound_material(prim)
        if not source:
            self._note_dangling(prim)
            if color is None:
                return None
        constant_color = color if not source or reads_display_color(source) else None
        key = (str(source.GetPath()) if source else "", constant_color, double_sided)
        if key not in self._known:
            entry, notes = (
                self._convert(source, constant_color, double_sided)
                if source
                else (_plain_material(constant_color, double_sided), [])
            )
            self._known[key] = self._index_of(entry, notes)
        return self._known[key]

    def _index_of(self, entry: ConvertedMaterial, notes: list[Diagnostic]) -> int:
        """The index of `entry`, appended unless an equal one, from another reference to the same file, exists."""
        for index, known in enumerate(self.entries):
            renamed = replace(known.material, name=entry.material.name)
            if known.source_name == entry.source_name and replace(known, material=renamed) == entry:
                return index
        self.diagnostics += notes
        self.entries.append(
            replace(entry, material=replace(entry.material, name=self._unused_name(entry.material.name)))
        )
        return len(self.entries) - 1

    def _unused_name(self, name: str) -> str:
        taken = {entry.material.name for entry in self.entries}
        return next(n for n in (name, *(f"{name}_{i}" for i in range(2, len(taken) + 3))) if n not in taken)

    def _note_dangling(self, prim: Usd.Prim) -> None:
        """One warning for each material that is bound, but not there."""
        binding = UsdShade.MaterialBindingAPI(prim).GetDirectBindingRel()
        for target in map(str, binding.GetTargets() if binding else []):
            if target not in self._dangling:
                self._dangling.add(target)
                headline = f"'{target}' is bound, but is no material"
                note = finding("asset/missing-material", headline, where=self._where(prim), value=target)
                self._repaired(note, "missing_material", material=target)

    def _repaired(self, diagnostic: Diagnostic, name: str, **before: str) -> None:
        self.diagnostics.append(diagnostic)
        self.repairs.append(Repair(name=name, code=diagnostic.code, stage=INTAKE, before=dict(before)))

    def _where(self, prim: Usd.Prim) -> Location:
        return self._layers.location_of(self._layers.root).where(prim=str(prim.GetPath()))

    def _convert(
        self, source: UsdShade.Material, color: Color | None, double_sided: bool
    ) -> tuple[ConvertedMaterial, list[Diagnostic]]:
        """The converted material, and what did not fit the model."""
        name = source.GetPrim().GetName()
        shader = surface_shader(source)
        if shader is None:
            return replace(_plain_material(color, double_sided, name), shows_mesh_colors=True, source_name=name), []
        ports = {port.GetBaseName(): port for port in shader.GetInputs()}
        dialect = dialect_of(shader_identifier(shader), tuple(ports))
        sources, authored = _read(dialect, ports)
        from_mesh = isinstance(sources.get("base_color"), PrimvarSource)
        if from_mesh:
            sources["base_color"] = color or (1.0, 1.0, 1.0)
        where = self._where(source.GetPrim())
        conversion = MaterialConversion(sources, authored, dialect.name, self._texture, where)
        material = conversion.material(name, double_sided, _unmapped(source, shader, dialect, ports))
        notes = conversion.diagnostics
        for other in _other_surfaces(source, shader):
            layers = self._layers_of(other, conversion.uv_names, where)
            material = with_layers_of(material, layers.material("", False, {}))
            notes += layers.diagnostics
        if material.unmapped:
            headline = f"'{name}' has {dialect.name} properties beyond the metallic-roughness model"
            names = ", ".join(sorted(material.unmapped))
            notes.append(finding("asset/material-extension-fallback", headline, where=where, value=names))
        return ConvertedMaterial(material, tuple(conversion.uv_names), from_mesh, name), notes

    def _layers_of(self, shader: UsdShade.Shader, uv_names: list[str], where: Location) -> MaterialConversion:
        """The conversion of what UsdPreviewSurface lacks, of another surface of a material; no other picture is read.

        Its textures read primvars that are added to `uv_names`.
        """
        ports = {port.GetBaseName(): port for port in shader.GetInputs()}
        dialect = dialect_of(shader_identifier(shader), tuple(ports))
        sources, authored = layer_sources(*_read(dialect, ports))
        conversion = MaterialConversion(sources, authored, dialect.name, self._texture, where)
        conversion.uv_names = uv_names
        return conversion

    def _texture(self, image: ImageSource) -> str | None:
        """The name of the texture an image node reads, or None with a warning when it cannot be read."""
        uri = to_json(image.file.Get(EARLIEST))
        stack = image.file.GetPropertyStack(EARLIEST)
        location = self._layers.location_of(stack[0].layer) if stack else self._layers.location_of(self._layers.root)
        where = location.where(prim=str(image.file.GetPath()))
        tiles = [t for u in tile_references(uri) if (t := location.resolve(u, prim=where.prim)) is not None]
        target = next(iter(tiles), None)
        key = target.identifier if target else f"{location.identifier} {uri}"
        if key in self._texture_names:
            return self._texture_names[key]
        if target is None:
            self._texture_names[key] = None
            diagnostic = finding("asset/missing-texture", f"texture '{uri}' is absent", where=where, value=uri)
            self._repaired(diagnostic, "missing_texture", texture=uri)
            return None
        if len(tiles) > 1:
            headline = f"'{uri}' has {len(tiles)} tiles; all of the surface shows {target.name}"
            diagnostic = finding("asset/unsupported-texture", headline, where=where, value=uri)
            self._repaired(diagnostic, "unsupported_texture", texture=uri)
        names = {texture.name for texture in self.textures}
        stem = posixpath.splitext(target.name)[0]
        name = next(n for n in (stem, *(f"{stem}_{i}" for i in range(2, len(names) + 3))) if n not in names)
        texture, diagnostics = self._load_texture(target.read(), name, where=where)
        for diagnostic in diagnostics:
            repair = diagnostic.code.removeprefix("asset/").replace("-", "_")
            self._repaired(diagnostic, repair, texture=uri)
        if texture is not None:
            self.textures.append(texture)
        self._texture_names[key] = texture.name if texture else None
        return self._texture_names[key]


def _plain_material(color: Color | None, double_sided: bool, name: str = "displayColor") -> ConvertedMaterial:
    return ConvertedMaterial(Material(name, base_color=color or (0.8, 0.8, 0.8), double_sided=double_sided))


def bound_material(prim: Usd.Prim) -> UsdShade.Material | None:
    """The material a prim resolves to (inheritance, strength, collections), for preview or else for full rendering."""
    api = UsdShade.MaterialBindingAPI(prim)
    for purpose in (UsdShade.Tokens.preview, UsdShade.Tokens.full):
        material, _ = api.ComputeBoundMaterial(purpose)
        if material:
            return material
    return None


def surface_shader(material: UsdShade.Material) -> UsdShade.Shader | None:
    """The shader of the material's surface: UsdPreviewSurface if it has one, else the first in any render context."""
    shaders = [
        node[0]
        for output in sorted(material.GetSurfaceOutputs(), key=lambda o: o.GetFullName())
        if (node := source_node(output))
    ]
    identified = [shader for shader in shaders if shader and shader_identifier(shader)]
    return next(
        (s for s in identified if dialect_of(shader_identifier(s), ()) is PREVIEW),
        identified[0] if identified else None,
    )


def _other_surfaces(material: UsdShade.Material, first: UsdShade.Shader) -> list[UsdShade.Shader]:
    """The surfaces of other render contexts that a known dialect has, MaterialX before MDL: OmniGlass has no texture of
    its transmission, which would be lost.
    """
    surfaces: list[UsdShade.Shader] = []
    for output in sorted(material.GetSurfaceOutputs(), key=lambda o: o.GetFullName()):
        node = source_node(output)
        shader = node[0] if node else None
        if shader and shader.GetPath() != first.GetPath() and is_known(shader_identifier(shader)):
            surfaces.append(shader)
    return sorted(surfaces, key=lambda s: DIALECTS.index(dialect_of(shader_identifier(s), ())))


def reads_display_color(material: UsdShade.Material) -> bool:
    """True iff the surface takes its colour from a primvar of the mesh."""
    shader = surface_shader(material)
    if shader is None:
        return True
    ports = {port.GetBaseName(): port for port in shader.GetInputs()}
    name = dialect_of(shader_identifier(shader), tuple(ports)).inputs["base_color"]
    return name in ports and isinstance(input_source(ports[name]), PrimvarSource)


def _read(dialect: ShaderDialect, ports: dict[str, UsdShade.Input]) -> tuple[dict[str, InputSource], dict[str, str]]:
    """The source of each quantity: authored values over the dialect's defaults, image inputs over both; and the input
    of each quantity that is authored.
    """
    sources: dict[str, InputSource] = dict(dialect.defaults)
    authored: dict[str, str] = {}
    for quantity, name in dialect.inputs.items():
        value = input_source(ports[name]) if name in ports else None
        if value is not None:
            sources[quantity] = value
            authored[quantity] = name
    for quantity, name in dialect.maps.items():
        value = input_source(ports[name]) if name in ports else None
        if isinstance(value, ImageSource):
            sources[f"{quantity}_map"] = value
            authored[quantity] = name
    packed = sources.get("orm_map")
    if sources.get("orm_switch") and isinstance(packed, ImageSource):
        sources["occlusion_map"] = replace(packed, channel="r")
        sources["roughness_map"] = replace(packed, channel="g")
        sources["metallic_map"] = replace(packed, channel="b")
        authored |= dict.fromkeys(("occlusion", "roughness", "metallic"), dialect.maps["orm"])
    return sources, authored


def _unmapped(
    source: UsdShade.Material, shader: UsdShade.Shader, dialect: ShaderDialect, ports: dict[str, UsdShade.Input]
) -> dict[str, Any]:
    """Source properties without a field in `Material`: leftover inputs, and for foreign shaders the whole network."""
    known = {*dialect.inputs.values(), *dialect.maps.values()}
    left = {name: _authored(port.GetAttr()) for name, port in sorted(ports.items()) if name not in known}
    unmapped: dict[str, Any] = {shader_identifier(shader): left} if left else {}
    if dialect is PREVIEW:
        return unmapped
    network = {
        str(prim.GetPath().MakeRelativePath(source.GetPath())): {
            a.GetName(): _authored(a)
            for a in prim.GetAuthoredAttributes()
            if a.GetName().startswith(("inputs:", "info:"))
        }
        for prim in Usd.PrimRange(source.GetPrim())
        if prim.IsA(UsdShade.Shader)
    }
    return {**unmapped, "shader": shader_identifier(shader), "network": network}


def _authored(attribute: Usd.Attribute) -> Any:
    """The attribute as JSON: the paths it is connected to, else its value."""
    return [str(path) for path in attribute.GetConnections()] or to_json(attribute.Get(EARLIEST))
