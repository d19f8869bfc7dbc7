"""KHR_materials_pbrSpecularGlossiness as metallic-roughness, texel by texel where it has pictures."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
from PIL import Image

from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.material_values import MaterialValues, rgb
from assetkit.readers.gltf.textures import Textures
from schemas.appearance.conversions import linear_to_srgb, metallic_from_specular, srgb_to_linear
from schemas.appearance.material import WHITE, Material, Texture, TextureUse
from schemas.arrays import FloatArray

_METHOD = "KHR_materials_pbrSpecularGlossiness, reference conversion of specular to metalness"
_SURE = 0.8  # The conversion looks alike at normal incidence, but not at grazing angles.
_WHITE_TEXEL = np.ones((1, 1, 4))


def with_specular_glossiness(extension: Json, values: MaterialValues, textures: Textures, base: Material) -> Material:
    """`base` with base colour, metalness, roughness and opacity of the extension.

    With a picture of specular colours, base colour and metalness become new pictures, of the larger of both sizes. That
    needs both to be sampled alike; where they are not, the surface counts as a dielectric of the diffuse colour.
    """
    *diffuse, alpha = values.fractions(extension, "diffuseFactor", (1.0, 1.0, 1.0, 1.0), "base_color")
    specular = values.fractions(extension, "specularFactor", WHITE, "metallic")
    glossiness = values.fraction(extension, "glossinessFactor", 1.0, "roughness")
    used = textures.use(extension.get("specularGlossinessTexture"))
    color_used = textures.use(extension.get("diffuseTexture"))
    color_use = None if color_used is None else color_used[0]
    for field in ("base_color", "metallic", "roughness"):
        values.infer(field, _METHOD, _SURE)
    opaque = base.alpha_mode == "opaque"
    alpha_use = None
    if not opaque and color_used is not None and color_used[1].extension == "png":  # JPEG has no alpha.
        alpha_use = replace(color_used[0], channel="a")
        values.declare("opacity_texture", "alpha of KHR_materials_pbrSpecularGlossiness.diffuseTexture")
    if not opaque:
        values.declare("opacity", "alpha of KHR_materials_pbrSpecularGlossiness.diffuseFactor")
    base = replace(base, opacity=1.0 if opaque else alpha, opacity_texture=alpha_use)
    if used is None:
        if color_use is None:
            color, metallic = metallic_from_specular(np.array(diffuse), np.array(specular))
            return replace(base, base_color=rgb(color.tolist()), metallic=float(metallic), roughness=1.0 - glossiness)
        use, picture = color_use, None
    else:
        use, picture = used
        if color_use is not None and not _alike(color_use, use):
            roughness = replace(use, channel="a", scale=-glossiness, bias=1.0)
            return replace(
                base,
                base_color=rgb(diffuse),
                base_color_texture=color_use,
                roughness=1.0,
                roughness_texture=roughness,
                metallic=0.0,
            )
    color_texels = _WHITE_TEXEL if color_used is None else _texels(color_used[1])
    gloss_texels = _WHITE_TEXEL if picture is None else _texels(picture)
    color_texels, gloss_texels = _same_size(color_texels, gloss_texels)
    base_texels, metal_texels = metallic_from_specular(
        srgb_to_linear(color_texels[..., :3]) * diffuse, srgb_to_linear(gloss_texels[..., :3]) * specular
    )
    name = (color_used or used or (None, Texture("specular", b"", "png", 1, 1)))[1].name
    rough_texels = 1.0 - gloss_texels[..., 3] * glossiness
    packed = np.stack([np.ones_like(metal_texels), rough_texels, metal_texels], axis=-1)
    colors = textures.derive(f"{name}_base_color", _png(linear_to_srgb(base_texels)))
    surface = textures.derive(f"{name}_roughness_metallic", _png(packed))
    plain = replace(use, channel="rgb", scale=1.0, bias=0.0)
    for field in ("base_color_texture", "metallic_texture", "roughness_texture"):
        values.infer(field, _METHOD, _SURE)
    return replace(
        base,
        base_color=WHITE,
        base_color_texture=replace(plain, texture=colors.name),
        metallic=1.0,
        metallic_texture=replace(plain, texture=surface.name, channel="b"),
        roughness=1.0,
        roughness_texture=replace(plain, texture=surface.name, channel="g"),
    )


def _alike(one: TextureUse, other: TextureUse) -> bool:
    """Whether two pictures are sampled at the same places."""
    return replace(one, texture="", channel="rgb") == replace(other, texture="", channel="rgb")


def _texels(texture: Texture) -> FloatArray:
    """(h, w, 4) display values in 0..1."""
    with Image.open(io.BytesIO(texture.data)) as image:
        return np.asarray(image.convert("RGBA"), dtype=np.float64) / 255.0


def _same_size(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Both at the larger number of rows and of columns."""
    rows, columns = (max(a, b) for a, b in zip(one.shape[:2], other.shape[:2], strict=True))
    return _resized(one, rows, columns), _resized(other, rows, columns)


def _resized(texels: FloatArray, rows: int, columns: int) -> FloatArray:
    if texels.shape[:2] == (rows, columns):
        return texels
    image = Image.fromarray(np.rint(texels * 255.0).astype(np.uint8))
    return np.asarray(image.resize((columns, rows), Image.Resampling.BILINEAR), dtype=np.float64) / 255.0


def _png(values: FloatArray) -> Texture:
    """An 8-bit picture (h, w, 3) of values in 0..1; its name comes later."""
    buffer = io.BytesIO()
    Image.fromarray(np.rint(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)).save(buffer, "PNG")
    return Texture("", buffer.getvalue(), "png", values.shape[1], values.shape[0])
