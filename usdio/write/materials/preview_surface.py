"""The UsdPreviewSurface of a material, which every renderer reads.

Specification: openusd.org/release/spec_usdpreviewsurface.html.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from pxr import Gf, Sdf, UsdShade

from schemas.appearance.conversions import ior_of_reflectance, reflectance_of_ior
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.appearance.optics import unlike_plain
from usdio.write.materials.mesh_materials import MeshMaterial, uv_primvar
from usdio.write.materials.network import IDENTITY_UV, Network
from usdio.write.materials.output import ShaderOutput

# UsdPreviewSurface has no transmission. Opacity replaces it; some is kept so that clear glass stays visible.
_LEAST_GLASS_OPACITY = 0.2
_SHOWN: Final = frozenset(
    {
        "base_color",
        "base_color_texture",
        "metallic",
        "metallic_texture",
        "roughness",
        "roughness_texture",
        "normal_texture",
        "normal_scale",
        "occlusion_texture",
        "emissive",
        "emissive_texture",
        "opacity",
        "opacity_texture",
        "alpha_mode",
        "alpha_cutoff",
        "double_sided",
        "ior",
        "clearcoat",
        "clearcoat_texture",
        "clearcoat_roughness",
        "clearcoat_roughness_texture",
    }
)


def _lost(mesh_material: MeshMaterial, images: Mapping[str, Texture]) -> frozenset[str]:
    """Everything beyond metallic-roughness with a coat; transmission is shown as opacity, which bends no light."""
    return unlike_plain(mesh_material.material) - _SHOWN


def _author(network: Network, mesh_material: MeshMaterial) -> None:
    _Surface(network, mesh_material).author()


def _shown_ior(material: Material) -> float:
    """The index that reflects at once what the material's own reflects, times its weight of specular light.

    KHR_materials_specular scales the reflectance of the index; UsdPreviewSurface has no weight. Textures of the weight
    and its tint are lost.
    """
    if material.specular is None or material.specular.weight_texture is not None:
        return material.ior
    return ior_of_reflectance(material.specular.weight * reflectance_of_ior(material.ior))


class _Surface:
    """The shader network of one material while it is being authored."""

    def __init__(self, network: Network, mesh_material: MeshMaterial) -> None:
        self._network = network
        self._mesh_material = mesh_material
        self._shared: dict[tuple[object, ...], UsdShade.Shader] = {}
        self._surface = network.shader("surface", "UsdPreviewSurface")

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
        self._input("ior", Sdf.ValueTypeNames.Float, _shown_ior(source))
        self._scalar("clearcoat", source.clearcoat, source.clearcoat_texture)
        self._scalar("clearcoatRoughness", source.clearcoat_roughness, source.clearcoat_roughness_texture)
        if source.occlusion_texture is not None:
            self._scalar("occlusion", 1.0, source.occlusion_texture)
        self._opacity()
        self._normal()
        self._network.connect_surface(self._surface, "surface", "")

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
        texture = self._network.shader(f"{name}_texture", "UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(self._network.files.paths[use.texture]))
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
        if placement == IDENTITY_UV:
            return output
        key = ("UsdTransform2d", use.uv_set, placement)
        if key not in self._shared:
            transform = self._network.shader(f"{name}_placement", "UsdTransform2d")
            transform.CreateInput("in", Sdf.ValueTypeNames.Float2).ConnectToSource(output)
            transform.CreateInput("scale", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(*use.uv_scale))
            transform.CreateInput("rotation", Sdf.ValueTypeNames.Float).Set(math.degrees(use.uv_rotation_rad))
            transform.CreateInput("translation", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(*use.uv_offset))
            self._shared[key] = transform
        return self._shared[key].CreateOutput("result", Sdf.ValueTypeNames.Float2)

    def _primvar_reader(self, name: str, kind: str, primvar: str) -> UsdShade.Shader:
        key = (kind, primvar)
        if key not in self._shared:
            reader = self._network.shader(name, kind)
            reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(primvar)
            self._shared[key] = reader
        return self._shared[key]

    def _input(self, name: str, kind: Sdf.ValueTypeName, value: object) -> UsdShade.Input:
        created = self._surface.CreateInput(name, kind)
        created.Set(value)
        return created


PREVIEW_SURFACE: Final = ShaderOutput("UsdPreviewSurface", "", _lost, _author)
