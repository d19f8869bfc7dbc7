"""Authors UsdPreviewSurface materials from `schemas.appearance.material.Material`.

Specification: openusd.org/release/spec_usdpreviewsurface.html.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from pxr import Gf, Sdf, Usd, UsdGeom, UsdSemantics, UsdShade

from schemas.appearance.material import Material, TextureUse
from schemas.identifiers import unique_identifiers
from schemas.model import Model
from usdio.write.mesh_materials import MeshMaterial, uv_primvar

# UsdPreviewSurface has no transmission. Opacity replaces it; some is kept so that clear glass stays visible.
_LEAST_GLASS_OPACITY = 0.2
_IDENTITY_UV = ((1.0, 1.0), 0.0, (0.0, 0.0))


def texture_uses(material: Material) -> tuple[TextureUse, ...]:
    """Every texture use that reaches the written shader."""
    uses = (
        material.base_color_texture,
        material.metallic_texture,
        material.roughness_texture,
        material.normal_texture,
        material.occlusion_texture,
        material.emissive_texture,
        None if material.alpha_mode == "opaque" else material.opacity_texture,
    )
    return tuple(use for use in uses if use is not None)


def texture_files(model: Model, mesh_materials: Sequence[MeshMaterial]) -> dict[str, str]:
    """Texture.name -> file name below `textures/` of every texture that a mesh material uses, in model order."""
    used = {use.texture for mesh_material in mesh_materials for use in texture_uses(mesh_material.material)}
    textures = [texture for texture in model.textures if texture.name in used]
    names = unique_identifiers((texture.name for texture in textures), "texture")
    return {texture.name: f"{file}.{texture.extension}" for file, texture in zip(names, textures, strict=True)}


def author_materials(
    stage: Usd.Stage, root: Sdf.Path, mesh_materials: Sequence[MeshMaterial], textures: Mapping[str, str], label: str
) -> None:
    """Define `<root>/Materials/<name>` for every distinct mesh material.

    `textures` maps Texture.name to an asset path relative to the layer; `label` is the material type for SL.MAT.001.
    """
    scope = UsdGeom.Scope.Define(stage, root.AppendChild("Materials")).GetPath()
    for name, mesh_material in sorted(
        {mesh_material.prim_name: mesh_material for mesh_material in mesh_materials}.items()
    ):
        material = UsdShade.Material.Define(stage, scope.AppendChild(name))
        label_material(material, label)
        material.GetPrim().SetCustomDataByKey("mana:sourceName", mesh_material.material.name)
        _Network(stage, material, mesh_material, textures).author()


def label_material(material: UsdShade.Material, label: str) -> None:
    """The `material` semantic label every Material prim must carry, physics ones too (SL.MAT.001)."""
    UsdSemantics.LabelsAPI.Apply(material.GetPrim(), "material").CreateLabelsAttr([label])


class _Network:
    """The shader network of one material while it is being authored."""

    def __init__(
        self, stage: Usd.Stage, material: UsdShade.Material, mesh_material: MeshMaterial, textures: Mapping[str, str]
    ) -> None:
        self._stage = stage
        self._material = material
        self._mesh_material = mesh_material
        self._textures = textures
        self._shared: dict[tuple[object, ...], UsdShade.Shader] = {}
        self._surface = self._shader("surface", "UsdPreviewSurface")

    def author(self) -> None:
        """Author every input of the surface and connect it to the material."""
        source = self._mesh_material.material
        self._input("useSpecularWorkflow", Sdf.ValueTypeNames.Int, 0)
        self._color("diffuseColor", source.base_color, source.base_color_texture)
        if self._mesh_material.vertex_colors:
            reader = self._primvar_reader("vertex_color", "UsdPrimvarReader_float3", "displayColor")
            output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
            self._surface.GetInput("diffuseColor").ConnectToSource(output)
        self._scalar("metallic", source.metallic, source.metallic_texture)
        self._scalar("roughness", source.roughness, source.roughness_texture)
        self._color("emissiveColor", source.emissive, source.emissive_texture)
        self._input("ior", Sdf.ValueTypeNames.Float, source.ior)
        self._input("clearcoat", Sdf.ValueTypeNames.Float, source.clearcoat)
        self._input("clearcoatRoughness", Sdf.ValueTypeNames.Float, source.clearcoat_roughness)
        if source.occlusion_texture is not None:
            self._scalar("occlusion", 1.0, source.occlusion_texture)
        self._opacity()
        self._normal()
        surface_output = self._surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        self._material.CreateSurfaceOutput().ConnectToSource(surface_output)

    def _opacity(self) -> None:
        source = self._mesh_material.material
        clear = max(1.0 - source.transmission, _LEAST_GLASS_OPACITY) if source.transmission > 0.0 else 1.0
        if source.alpha_mode == "opaque":
            self._input("opacity", Sdf.ValueTypeNames.Float, clear)
            return
        self._scalar("opacity", source.opacity * clear, source.opacity_texture)
        threshold = source.alpha_cutoff if source.alpha_mode == "mask" else 0.0
        self._input("opacityThreshold", Sdf.ValueTypeNames.Float, threshold)
        if self._mesh_material.vertex_colors and source.opacity_texture is None:
            reader = self._primvar_reader("vertex_opacity", "UsdPrimvarReader_float", "displayOpacity")
            output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float)
            self._surface.GetInput("opacity").ConnectToSource(output)

    def _normal(self) -> None:
        """Tangent-space map in [0, 1] to vectors: scale 2, bias -1; `normal_scale` scales x and y as in glTF."""
        source = self._mesh_material.material
        if source.normal_texture is None:
            return
        s = source.normal_scale
        texture = self._texture(
            "normal", source.normal_texture, (2 * s, 2 * s, 2.0, 1.0), (-s, -s, -1.0, 0.0), (0.0, 0.0, 1.0, 1.0), "raw"
        )
        normal = self._surface.CreateInput("normal", Sdf.ValueTypeNames.Normal3f)
        normal.ConnectToSource(texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3))

    def _color(self, name: str, factor: tuple[float, float, float], use: TextureUse | None) -> None:
        color = self._input(name, Sdf.ValueTypeNames.Color3f, Gf.Vec3f(*factor))
        if use is None:
            return
        r, g, b = factor
        scale = (use.scale * r, use.scale * g, use.scale * b, 1.0)
        bias = (use.bias * r, use.bias * g, use.bias * b, 0.0)
        texture = self._texture(name, use, scale, bias, (r, g, b, 1.0), "sRGB")
        color.ConnectToSource(texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3))

    def _scalar(self, name: str, factor: float, use: TextureUse | None) -> None:
        """Data channels are `raw` and never share a reader with a colour of the same image (VM.TEX.003)."""
        scalar = self._input(name, Sdf.ValueTypeNames.Float, factor)
        if use is None:
            return
        scale, bias = use.scale * factor, use.bias * factor
        texture = self._texture(name, use, (scale,) * 4, (bias,) * 4, (factor,) * 4, "raw")
        channel = "r" if use.channel == "rgb" else use.channel
        scalar.ConnectToSource(texture.CreateOutput(channel, Sdf.ValueTypeNames.Float))

    def _texture(
        self,
        name: str,
        use: TextureUse,
        scale: tuple[float, ...],
        bias: tuple[float, ...],
        fallback: tuple[float, ...],
        color_space: str,
    ) -> UsdShade.Shader:
        """The UsdUVTexture for one sampling; equal samplings share one (packed occlusion-roughness-metallic)."""
        placement = (use.uv_scale, use.uv_rotation_rad, use.uv_offset)
        key = (use.texture, use.uv_set, use.wrap_s, use.wrap_t, placement, scale, bias, fallback, color_space)
        if key in self._shared:
            return self._shared[key]
        texture = self._shader(f"{name}_texture", "UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(self._textures[use.texture]))
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set(color_space)
        texture.CreateInput("wrapS", Sdf.ValueTypeNames.Token).Set(use.wrap_s)
        texture.CreateInput("wrapT", Sdf.ValueTypeNames.Token).Set(use.wrap_t)
        texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*scale))
        texture.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*bias))
        texture.CreateInput("fallback", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*fallback))
        coordinates = self._coordinates(name, use)
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(coordinates)
        self._shared[key] = texture
        return texture

    def _coordinates(self, name: str, use: TextureUse) -> UsdShade.Output:
        primvar = uv_primvar(use.uv_set)
        reader = self._primvar_reader(f"{primvar}_reader", "UsdPrimvarReader_float2", primvar)
        output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        placement = (use.uv_scale, use.uv_rotation_rad, use.uv_offset)
        if placement == _IDENTITY_UV:
            return output
        key = ("UsdTransform2d", use.uv_set, placement)
        if key not in self._shared:
            transform = self._shader(f"{name}_placement", "UsdTransform2d")
            transform.CreateInput("in", Sdf.ValueTypeNames.Float2).ConnectToSource(output)
            transform.CreateInput("scale", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(*use.uv_scale))
            transform.CreateInput("rotation", Sdf.ValueTypeNames.Float).Set(math.degrees(use.uv_rotation_rad))
            transform.CreateInput("translation", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(*use.uv_offset))
            self._shared[key] = transform
        return self._shared[key].CreateOutput("result", Sdf.ValueTypeNames.Float2)

    def _primvar_reader(self, name: str, kind: str, primvar: str) -> UsdShade.Shader:
        key = (kind, primvar)
        if key not in self._shared:
            reader = self._shader(name, kind)
            reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(primvar)
            self._shared[key] = reader
        return self._shared[key]

    def _shader(self, name: str, kind: str) -> UsdShade.Shader:
        shader = UsdShade.Shader.Define(self._stage, self._material.GetPath().AppendChild(name))
        shader.CreateIdAttr(kind)
        return shader

    def _input(self, name: str, kind: Sdf.ValueTypeName, value: object) -> UsdShade.Input:
        created = self._surface.CreateInput(name, kind)
        created.Set(value)
        return created
