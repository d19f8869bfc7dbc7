"""The optical model of a surface: metallic-roughness PBR with the layers that glTF's ratified extensions add to it.

All values are immutable; editing means `dataclasses.replace`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, Literal

from schemas.evidence import Source

Channel = Literal["r", "g", "b", "a", "rgb"]
AlphaMode = Literal["opaque", "mask", "blend"]
NormalGreen = Literal["up", "undeclared"]
LinearRGB = tuple[float, float, float]
WHITE: LinearRGB = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Texture:
    """An image file, byte for byte as the source holds it (PNG or JPEG; other formats are converted to PNG).

    Released ones may be derived: turned normal maps, halves of pictures with alpha, smaller ones.
    """

    name: str  # unique within the model, without extension
    data: bytes
    extension: Literal["png", "jpg"]
    width: int
    height: int


@dataclass(frozen=True)
class TextureUse:
    """One sampling of a texture by a material input; the sampled value is `texel * scale + bias`."""

    texture: str  # Texture.name
    channel: Channel = "rgb"
    uv_set: int = 0
    wrap_s: Literal["repeat", "clamp", "mirror", "black"] = "repeat"
    wrap_t: Literal["repeat", "clamp", "mirror", "black"] = "repeat"
    # UV transform in the USD order (scale, then rotate, then translate), with v pointing up.
    uv_scale: tuple[float, float] = (1.0, 1.0)
    uv_rotation_rad: float = 0.0
    uv_offset: tuple[float, float] = (0.0, 0.0)
    scale: float = 1.0
    bias: float = 0.0


@dataclass(frozen=True)
class Origin:
    """Where one value of a material comes from: `method` is the property of the source and the formula applied to it.

    `declared` is stated by the source, at confidence `schemas.evidence.BY_STANDARD` where its format fills the value
    in; `inferred` is a conversion or a guess. A value without an origin is a default of `Material`, confidence 0.
    """

    source: Source
    method: str
    confidence: float = 1.0


@dataclass(frozen=True)
class Specular:
    """The dielectric reflection (KHR_materials_specular): its weight, and its colour at normal incidence."""

    weight: float = 1.0
    weight_texture: TextureUse | None = None
    color: LinearRGB = WHITE
    color_texture: TextureUse | None = None


@dataclass(frozen=True)
class Volume:
    """The inside of a transmissive body (KHR_materials_volume). Lengths have the unit of the model's points.

    `thickness` 0 is a thin wall; at `attenuation_distance` light has become `attenuation_color`.
    """

    thickness: float = 0.0
    thickness_texture: TextureUse | None = None
    attenuation_distance: float = float("inf")
    attenuation_color: LinearRGB = WHITE


@dataclass(frozen=True)
class Sheen:
    """The layer of fibres of a fabric (KHR_materials_sheen)."""

    color: LinearRGB
    color_texture: TextureUse | None = None
    roughness: float = 0.0
    roughness_texture: TextureUse | None = None


@dataclass(frozen=True)
class Anisotropy:
    """Highlights stretched along the tangent, turned by `rotation_rad` counter-clockwise (KHR_materials_anisotropy)."""

    strength: float
    rotation_rad: float = 0.0
    texture: TextureUse | None = None


@dataclass(frozen=True)
class Iridescence:
    """A thin film (KHR_materials_iridescence); a texture maps its thickness in nanometres from least to most."""

    factor: float
    texture: TextureUse | None = None
    ior: float = 1.3
    thickness_nm: tuple[float, float] = (100.0, 400.0)
    thickness_texture: TextureUse | None = None


@dataclass(frozen=True)
class DiffuseTransmission:
    """Light that comes through scattered, as through paper and leaves (KHR_materials_diffuse_transmission)."""

    factor: float
    texture: TextureUse | None = None
    color: LinearRGB = WHITE
    color_texture: TextureUse | None = None


@dataclass(frozen=True)
class Material:
    """Metallic-roughness PBR. Colours are linear RGB in 0..1, `emissive` may be brighter; a texture multiplies the
    scalar beside it. A layer is None where the surface has none.

    `dispersion` is 20 divided by the Abbe number (KHR_materials_dispersion). `unlit` surfaces show their base colour
    whatever the light. `normal_green` is whether the source defines that green of its normal maps is up along v
    (OpenGL's way, which all maps of released materials have), or leaves it open. `origins` gives the origin of values
    by field, of layers as "sheen.color". `lost_textures` are the fields whose picture the source names but that could
    not be had. `unmapped` keeps every source property that has no field here, as plain JSON, so that nothing is lost
    silently.
    """

    name: str
    base_color: LinearRGB = (0.8, 0.8, 0.8)
    base_color_texture: TextureUse | None = None
    metallic: float = 0.0
    metallic_texture: TextureUse | None = None
    roughness: float = 0.5
    roughness_texture: TextureUse | None = None
    normal_texture: TextureUse | None = None
    normal_scale: float = 1.0
    normal_green: NormalGreen = "up"
    occlusion_texture: TextureUse | None = None
    emissive: LinearRGB = (0.0, 0.0, 0.0)
    emissive_texture: TextureUse | None = None
    opacity: float = 1.0
    opacity_texture: TextureUse | None = None
    alpha_mode: AlphaMode = "opaque"
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    ior: float = 1.5
    clearcoat: float = 0.0
    clearcoat_texture: TextureUse | None = None
    clearcoat_roughness: float = 0.0
    clearcoat_roughness_texture: TextureUse | None = None
    clearcoat_normal_texture: TextureUse | None = None
    clearcoat_normal_scale: float = 1.0
    transmission: float = 0.0
    transmission_texture: TextureUse | None = None
    dispersion: float = 0.0
    specular: Specular | None = None
    volume: Volume | None = None
    sheen: Sheen | None = None
    anisotropy: Anisotropy | None = None
    iridescence: Iridescence | None = None
    diffuse_transmission: DiffuseTransmission | None = None
    unlit: bool = False
    origins: Mapping[str, Origin] = field(default_factory=dict[str, Origin])
    unmapped: dict[str, Any] = field(default_factory=dict[str, Any])
    lost_textures: tuple[str, ...] = ()

    @property
    def texture_uses(self) -> dict[str, TextureUse]:
        """Every texture use by its field, of layers as "sheen.color_texture", in the order of the fields."""
        return _texture_uses(self, "")

    def with_value(self, field_name: str, value: Any) -> Material:
        """The material with one field, of layers as "sheen.color", replaced."""
        layer, _, name = field_name.rpartition(".")
        if not layer:
            return replace(self, **{name: value})
        return replace(self, **{layer: replace(getattr(self, layer), **{name: value})})


def _texture_uses(layer: Any, prefix: str) -> dict[str, TextureUse]:
    uses: dict[str, TextureUse] = {}
    for entry in fields(layer):
        value = getattr(layer, entry.name)
        if isinstance(value, TextureUse):
            uses[f"{prefix}{entry.name}"] = value
        elif is_dataclass(value):
            uses |= _texture_uses(value, f"{entry.name}.")
    return uses
