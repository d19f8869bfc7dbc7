"""The OpenPBR surface of a material as a MaterialX network, the recommended final surface of SimReady assets.

Sources: OpenPBR 1.1 specification; MaterialX 1.39 node definitions (open_pbr_surface, stdlib); SimReady VM.PBR.001-003,
VM.TEX.004. Colours are read as `srgb_texture`, data as `none`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from pxr import Sdf, UsdShade

from schemas.appearance.material import WHITE, LinearRGB, Material, Texture, TextureUse
from schemas.appearance.optics import inner_color, is_thin_walled, unlike_plain
from usdio.write.materials.mesh_materials import MeshMaterial, uv_primvar
from usdio.write.materials.network import IDENTITY_UV, Network, Types, set_file, set_input
from usdio.write.materials.output import ShaderOutput

NITS_OF_WHITE: Final = 1000.0  # emission 1 in units of the display; as MaterialX's translation of standard_surface
COAT_IOR: Final = 1.5  # KHR_materials_clearcoat: a coat has the index of refraction 1.5
ABBE_SCALE: Final = 20.0  # KHR_materials_dispersion: dispersion is 20 / Abbe number
MOST_IOR: Final = 3.0  # SimReady VM.PBR.002
_NOT_SHOWN: Final = frozenset({"occlusion_texture", "volume.thickness_texture", "anisotropy.texture", "unlit"})
_ADDRESS: Final = {"repeat": "periodic", "clamp": "clamp", "mirror": "mirror", "black": "constant"}
_CHANNELS: Final = {"rgb": "outr", "r": "outr", "g": "outg", "b": "outb", "a": "outa"}


def _lost(mesh_material: MeshMaterial, images: Mapping[str, Texture]) -> frozenset[str]:
    """Ambient occlusion, a map of the thickness (rays find the real one), directions of an anisotropy map, and unlit.

    An index of refraction above 3 is shown as 3.
    """
    material = mesh_material.material
    lost = set(unlike_plain(material) & _NOT_SHOWN)
    if material.ior > MOST_IOR:
        lost.add("ior")
    if material.specular is not None and max(material.specular.color) > 1.0:
        lost.add("specular.color")
    return frozenset(lost)


def _author(network: Network, mesh_material: MeshMaterial) -> None:
    surface = _Surface(network)
    material = mesh_material.material
    surface.base(material, mesh_material.vertex_colors)
    surface.light(material)
    surface.coat(material)
    surface.layers(material)
    surface.directions(material)
    network.connect_surface(surface.shader, "out", "mtlx")


class _Surface:
    """The surface shader and the nodes that feed it."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self.shader = network.shader("surface", "ND_open_pbr_surface_surfaceshader")

    def base(self, material: Material, vertex_colors: bool) -> None:
        """Base, reflection and coverage."""
        self._color("base_color", material.base_color, material.base_color_texture)
        if vertex_colors:
            colors = self._primvar("ND_geompropvalue_color3", Types.Color3f, "displayColor")
            self.shader.GetInput("base_color").ConnectToSource(colors)
        self._scalar("base_metalness", material.metallic, material.metallic_texture)
        self._scalar("specular_roughness", material.roughness, material.roughness_texture)
        set_input(self.shader, "specular_ior", Types.Float, min(material.ior, MOST_IOR))
        if material.specular is not None:
            r, g, b = (min(c, 1.0) for c in material.specular.color)
            self._scalar("specular_weight", material.specular.weight, material.specular.weight_texture)
            self._color("specular_color", (r, g, b), material.specular.color_texture)
        if material.alpha_mode != "opaque":
            self._opacity(material, vertex_colors)

    def _opacity(self, material: Material, vertex_colors: bool) -> None:
        port = self._scalar("geometry_opacity", material.opacity, material.opacity_texture)
        if vertex_colors and material.opacity_texture is None:
            port.ConnectToSource(self._primvar("ND_geompropvalue_float", Types.Float, "displayOpacity"))
        if material.alpha_mode == "mask":
            test = self._network.shader("opacity_mask", "ND_ifgreatereq_float")
            value = set_input(test, "value1", Types.Float, material.opacity)
            sources = port.GetConnectedSources()[0]
            if sources:
                value.ConnectToSource(sources[0])
            set_input(test, "value2", Types.Float, material.alpha_cutoff)
            set_input(test, "in1", Types.Float, 1.0)
            set_input(test, "in2", Types.Float, 0.0)
            port.ConnectToSource(test.CreateOutput("out", Types.Float))

    def light(self, material: Material) -> None:
        """Emission, and what passes through."""
        strength = max(material.emissive)
        if strength > 0.0:
            r, g, b = (c / strength for c in material.emissive)
            self._color("emission_color", (r, g, b), material.emissive_texture)
            set_input(self.shader, "emission_luminance", Types.Float, NITS_OF_WHITE * strength)
        if material.transmission > 0.0:
            self._scalar("transmission_weight", material.transmission, material.transmission_texture)
            color, depth = inner_color(material)
            tint = material.base_color_texture if depth == 0.0 else None
            self._color("transmission_color", color, tint)
            set_input(self.shader, "transmission_depth", Types.Float, depth)
            set_input(self.shader, "geometry_thin_walled", Types.Bool, is_thin_walled(material))
        if material.dispersion > 0.0:
            set_input(self.shader, "transmission_dispersion_scale", Types.Float, 1.0)
            abbe = ABBE_SCALE / material.dispersion
            set_input(self.shader, "transmission_dispersion_abbe_number", Types.Float, abbe)

    def coat(self, material: Material) -> None:
        """The clear coat of KHR_materials_clearcoat: index 1.5, and no darkening of what lies below."""
        if material.clearcoat > 0.0:
            self._scalar("coat_weight", material.clearcoat, material.clearcoat_texture)
            self._scalar("coat_roughness", material.clearcoat_roughness, material.clearcoat_roughness_texture)
            set_input(self.shader, "coat_ior", Types.Float, COAT_IOR)
            set_input(self.shader, "coat_darkening", Types.Float, 0.0)

    def layers(self, material: Material) -> None:
        """Sheen, thin film, and light scattered through a thin wall."""
        sheen, film, through = material.sheen, material.iridescence, material.diffuse_transmission
        if sheen is not None:
            weight = min(max(sheen.color), 1.0)
            r, g, b = (min(c / weight, 1.0) for c in sheen.color)
            set_input(self.shader, "fuzz_weight", Types.Float, weight)
            self._color("fuzz_color", (r, g, b), sheen.color_texture)
            self._scalar("fuzz_roughness", sheen.roughness, sheen.roughness_texture)
        if film is not None:
            least, most = (nm / 1000.0 for nm in film.thickness_nm)  # micrometres
            self._scalar("thin_film_weight", film.factor, film.texture)
            self._scalar("thin_film_thickness", most, film.thickness_texture, scale=most - least, offset=least)
            set_input(self.shader, "thin_film_ior", Types.Float, film.ior)
        if through is not None:  # OpenPBR: a thin-walled subsurface that scatters forward only transmits.
            self._scalar("subsurface_weight", through.factor, through.texture)
            self._color("subsurface_color", through.color, through.color_texture)
            set_input(self.shader, "subsurface_scatter_anisotropy", Types.Float, 1.0)
            set_input(self.shader, "geometry_thin_walled", Types.Bool, True)

    def directions(self, material: Material) -> None:
        """Normal maps of base and coat; the tangent of an anisotropic surface."""
        self._normal("geometry_normal", material.normal_texture, material.normal_scale)
        self._normal("geometry_coat_normal", material.clearcoat_normal_texture, material.clearcoat_normal_scale)
        if material.anisotropy is None:
            return
        set_input(self.shader, "specular_roughness_anisotropy", Types.Float, material.anisotropy.strength)
        if material.anisotropy.rotation_rad:
            turned = self._network.shader("turned_tangent", "ND_rotate3d_vector3")
            for name, identifier in (("in", "ND_tangent_vector3"), ("axis", "ND_normal_vector3")):
                node = self._network.shader("tangent" if name == "in" else "normal", identifier)
                set_input(node, "space", Types.String, "world")
                turned.CreateInput(name, Types.Float3).ConnectToSource(node.CreateOutput("out", Types.Float3))
            # rotate3d turns clockwise about its axis, the rotation of glTF is counter-clockwise.
            set_input(turned, "amount", Types.Float, -math.degrees(material.anisotropy.rotation_rad))
            tangent = self.shader.CreateInput("geometry_tangent", Types.Float3)
            tangent.ConnectToSource(turned.CreateOutput("out", Types.Float3))

    def _normal(self, name: str, use: TextureUse | None, strength: float) -> None:
        if use is None:
            return
        image = self._image(use, "ND_image_vector3", Types.Float3, "none")
        node = self._network.shader(name.removeprefix("geometry_"), "ND_normalmap_float")
        node.CreateInput("in", Types.Float3).ConnectToSource(image.CreateOutput("out", Types.Float3))
        set_input(node, "scale", Types.Float, strength)
        self.shader.CreateInput(name, Types.Float3).ConnectToSource(node.CreateOutput("out", Types.Float3))

    def _color(self, name: str, factor: LinearRGB, use: TextureUse | None) -> UsdShade.Input:
        """The factor, or the texture times it: (texel * scale + bias) * factor."""
        port = set_input(self.shader, name, Types.Color3f, factor)
        if use is not None:
            image = self._image(use, "ND_image_color3", Types.Color3f, "srgb_texture")
            output = image.CreateOutput("out", Types.Color3f)
            scale, offset = _scaled(factor, use.scale), _scaled(factor, use.bias)
            output = self._arithmetic(name, "multiply", Types.Color3f, output, scale, WHITE)
            port.ConnectToSource(self._arithmetic(name, "add", Types.Color3f, output, offset, (0.0, 0.0, 0.0)))
        return port

    def _scalar(
        self, name: str, factor: float, use: TextureUse | None, *, scale: float | None = None, offset: float = 0.0
    ) -> UsdShade.Input:
        """The factor, or the channel of a texture times `scale` (usually the factor) plus `offset`."""
        port = set_input(self.shader, name, Types.Float, factor)
        if use is not None:
            gain = factor if scale is None else scale
            output = self._channel(use)
            output = self._arithmetic(name, "multiply", Types.Float, output, gain * use.scale, 1.0)
            offset += gain * use.bias
            port.ConnectToSource(self._arithmetic(name, "add", Types.Float, output, offset, 0.0))
        return port

    def _channel(self, use: TextureUse) -> UsdShade.Output:
        """One channel of a picture of data."""
        alpha = use.channel == "a"
        kind = "color4" if alpha else "color3"
        image = self._image(use, f"ND_image_{kind}", Types.Color4f if alpha else Types.Color3f, "none")
        identifier = f"ND_separate{4 if alpha else 3}_{kind}"

        def author() -> UsdShade.Shader:
            node = self._network.shader("channels", identifier)
            pixel = image.CreateOutput("out", Types.Color4f if alpha else Types.Color3f)
            node.CreateInput("in", Types.Color4f if alpha else Types.Color3f).ConnectToSource(pixel)
            return node

        split = self._network.once((identifier, image.GetPath()), author)
        return split.CreateOutput(_CHANNELS[use.channel], Types.Float)

    def _arithmetic(
        self,
        name: str,
        operation: str,
        kind: Sdf.ValueTypeName,
        source: UsdShade.Output,
        value: float | LinearRGB,
        neutral: float | LinearRGB,
    ) -> UsdShade.Output:
        """`source` combined with a constant, or itself where that would change nothing."""
        if value == neutral:
            return source
        suffix = "float" if kind == Types.Float else "color3"
        node = self._network.shader(f"{name}_{operation}", f"ND_{operation}_{suffix}")
        node.CreateInput("in1", kind).ConnectToSource(source)
        set_input(node, "in2", kind, value)
        return node.CreateOutput("out", kind)

    def _image(self, use: TextureUse, identifier: str, kind: Sdf.ValueTypeName, color_space: str) -> UsdShade.Shader:
        placement = (use.uv_scale, use.uv_rotation_rad, use.uv_offset)
        key = (identifier, use.texture, use.uv_set, use.wrap_s, use.wrap_t, placement, color_space)

        def author() -> UsdShade.Shader:
            image = self._network.shader("image", identifier)
            set_file(image, "file", self._network.files.paths[use.texture], color_space)
            set_input(image, "uaddressmode", Types.String, _ADDRESS[use.wrap_s])
            set_input(image, "vaddressmode", Types.String, _ADDRESS[use.wrap_t])
            image.CreateInput("texcoord", Types.Float2).ConnectToSource(self._coordinates(use))
            image.CreateOutput("out", kind)
            return image

        return self._network.once(key, author)

    def _coordinates(self, use: TextureUse) -> UsdShade.Output:
        """Texture coordinates; `place2d` divides by its scale, turns clockwise and subtracts its offset."""
        primvar = uv_primvar(use.uv_set)
        coordinates = self._primvar("ND_geompropvalue_vector2", Types.Float2, primvar)
        placement = (use.uv_scale, use.uv_rotation_rad, use.uv_offset)
        if placement == IDENTITY_UV:
            return coordinates

        def author() -> UsdShade.Shader:
            node = self._network.shader("placement", "ND_place2d_vector2")
            node.CreateInput("texcoord", Types.Float2).ConnectToSource(coordinates)
            set_input(node, "scale", Types.Float2, (_inverse(use.uv_scale[0]), _inverse(use.uv_scale[1])))
            set_input(node, "rotate", Types.Float, -math.degrees(use.uv_rotation_rad))
            set_input(node, "offset", Types.Float2, (-use.uv_offset[0], -use.uv_offset[1]))
            return node

        return self._network.once((primvar, placement), author).CreateOutput("out", Types.Float2)

    def _primvar(self, identifier: str, kind: Sdf.ValueTypeName, name: str) -> UsdShade.Output:
        def author() -> UsdShade.Shader:
            reader = self._network.shader(name, identifier)
            set_input(reader, "geomprop", Types.String, name)
            return reader

        return self._network.once((identifier, name), author).CreateOutput("out", kind)


def _scaled(color: LinearRGB, factor: float) -> LinearRGB:
    return (color[0] * factor, color[1] * factor, color[2] * factor)


def _inverse(scale: float) -> float:
    """1 / scale; a scale of 0, which shows one texel everywhere, as that of a huge picture."""
    return 1.0 / scale if scale else 1e6


OPEN_PBR: Final = ShaderOutput("OpenPBR", "mtlx", _lost, _author)
