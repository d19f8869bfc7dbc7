"""Every ratified material extension of glTF: each property reaches its field, and each value says where it is from."""

from __future__ import annotations

import io
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from assetkit.readers.gltf.extensions import SUPPORTED
from assetkit.readers.gltf.material_layers import LAYERS
from schemas.appearance.conversions import linear_to_srgb, metallic_from_specular, srgb_to_linear
from schemas.appearance.material import (
    Anisotropy,
    DiffuseTransmission,
    Iridescence,
    Material,
    Sheen,
    Specular,
    TextureUse,
    Volume,
)
from schemas.evidence import BY_STANDARD
from tests.assetkit.readers.gltf.test_materials import look, textured
from tests.support.gltf_files import png

PICTURE = {"index": 0}


def use(channel: Any = "rgb") -> TextureUse:
    return TextureUse("image_0", channel)


# Properties of each extension, and the fields that they fill.
ROWS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "KHR_materials_anisotropy": (
        {"anisotropyStrength": 0.6, "anisotropyRotation": 1.57, "anisotropyTexture": PICTURE},
        {"anisotropy": Anisotropy(0.6, 1.57, use())},
    ),
    "KHR_materials_clearcoat": (
        {
            "clearcoatFactor": 0.5,
            "clearcoatTexture": PICTURE,
            "clearcoatRoughnessFactor": 0.25,
            "clearcoatRoughnessTexture": PICTURE,
            "clearcoatNormalTexture": {**PICTURE, "scale": 0.7},
        },
        {
            "clearcoat": 0.5,
            "clearcoat_texture": use("r"),
            "clearcoat_roughness": 0.25,
            "clearcoat_roughness_texture": use("g"),
            "clearcoat_normal_texture": use(),
            "clearcoat_normal_scale": 0.7,
        },
    ),
    "KHR_materials_diffuse_transmission": (
        {
            "diffuseTransmissionFactor": 0.3,
            "diffuseTransmissionTexture": PICTURE,
            "diffuseTransmissionColorFactor": [0.1, 0.2, 0.3],
            "diffuseTransmissionColorTexture": PICTURE,
        },
        {"diffuse_transmission": DiffuseTransmission(0.3, use("a"), (0.1, 0.2, 0.3), use())},
    ),
    "KHR_materials_dispersion": ({"dispersion": 0.4}, {"dispersion": 0.4}),
    "KHR_materials_emissive_strength": ({"emissiveStrength": 4.0}, {"emissive": (4.0, 2.0, 0.0)}),
    "KHR_materials_ior": ({"ior": 1.33}, {"ior": 1.33}),
    "KHR_materials_iridescence": (
        {
            "iridescenceFactor": 0.8,
            "iridescenceTexture": PICTURE,
            "iridescenceIor": 1.4,
            "iridescenceThicknessMinimum": 200.0,
            "iridescenceThicknessMaximum": 500.0,
            "iridescenceThicknessTexture": PICTURE,
        },
        {"iridescence": Iridescence(0.8, use("r"), 1.4, (200.0, 500.0), use("g"))},
    ),
    "KHR_materials_sheen": (
        {
            "sheenColorFactor": [0.8, 0.2, 0.1],
            "sheenColorTexture": PICTURE,
            "sheenRoughnessFactor": 0.4,
            "sheenRoughnessTexture": PICTURE,
        },
        {"sheen": Sheen((0.8, 0.2, 0.1), use(), 0.4, use("a"))},
    ),
    "KHR_materials_specular": (
        {
            "specularFactor": 0.5,
            "specularTexture": PICTURE,
            "specularColorFactor": [1.5, 1.0, 0.5],
            "specularColorTexture": PICTURE,
        },
        {"specular": Specular(0.5, use("a"), (1.5, 1.0, 0.5), use())},
    ),
    "KHR_materials_transmission": (
        {"transmissionFactor": 0.75, "transmissionTexture": PICTURE},
        {"transmission": 0.75, "transmission_texture": use("r")},
    ),
    "KHR_materials_unlit": ({}, {"unlit": True, "metallic": 0.0, "roughness": 1.0}),
    "KHR_materials_volume": (
        {
            "thicknessFactor": 0.02,
            "thicknessTexture": PICTURE,
            "attenuationDistance": 0.5,
            "attenuationColor": [1, 0, 0],
        },
        {"volume": Volume(0.02, use("g"), 0.5, (1, 0, 0))},
    ),
}


def test_every_extension_that_may_be_required_has_a_row():
    others = {"KHR_materials_pbrSpecularGlossiness", "KHR_materials_variants"}
    assert LAYERS.keys() == ROWS.keys() == {name for name in SUPPORTED if name.startswith("KHR_materials_")} - others


@pytest.mark.parametrize("name", ROWS)
def test_each_property_reaches_its_field_and_nothing_else_changes(name: str, tmp_path: Path):
    properties, expected = ROWS[name]
    plain, _ = look(tmp_path, textured(png(), emissiveFactor=[1, 0.5, 0]))
    material, outcome = look(tmp_path, textured(png(), emissiveFactor=[1, 0.5, 0], extensions={name: properties}))
    assert replace(material, origins={}) == replace(plain, origins={}, **expected)
    assert (material.unmapped, outcome.diagnostics, outcome.repairs) == ({}, (), ())


@pytest.mark.parametrize("name", ROWS)
def test_each_value_says_where_it_is_from(name: str, tmp_path: Path):
    """A field that differs from the default of the model has an origin; what the file leaves out is half sure."""
    properties, _ = ROWS[name]
    for stated in (properties, {}):
        material, _ = look(tmp_path, textured(png(), emissiveFactor=[1, 0.5, 0], extensions={name: stated}))
        default = Material(material.name)
        differing = {f.name for f in fields(Material) if getattr(material, f.name) != getattr(default, f.name)}
        told = {field.partition(".")[0] for field in material.origins}
        assert differing - {"origins", "unmapped"} <= told
        for field, origin in material.origins.items():
            left_out = "left out" in origin.method
            assert (origin.source, origin.confidence) == ("declared", BY_STANDARD if left_out else 1.0), field


def test_values_out_of_range_are_limited_and_said(tmp_path: Path):
    extensions = {
        "KHR_materials_sheen": {"sheenColorFactor": [2, 0, 0]},
        "KHR_materials_dispersion": {"dispersion": -1},
    }
    material, outcome = look(tmp_path, textured(extensions=extensions))
    assert material.sheen is not None
    assert (material.sheen.color, material.dispersion) == ((1.0, 0.0, 0.0), 0.0)
    assert [d.code for d in outcome.diagnostics] == ["asset/invalid-material-value"]


def picture(texels: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(np.rint(texels * 255).astype(np.uint8)).save(buffer, "PNG")
    return buffer.getvalue()


def texels_of(outcome: Any, use_: TextureUse | None) -> np.ndarray:
    assert use_ is not None
    texture = next(t for t in outcome.value.textures if t.name == use_.texture)
    return np.asarray(Image.open(io.BytesIO(texture.data)), dtype=float) / 255.0


@pytest.mark.parametrize("sizes", [(4, 4), (2, 4), (4, 2)])
def test_specular_glossiness_is_converted_texel_by_texel(sizes: tuple[int, int], tmp_path: Path):
    """Gold beside blue paint in one picture: metal where the specular colour is, paint where it is not."""
    gold, paint = np.array([1.0, 0.77, 0.34]), np.array([0.1, 0.2, 0.8])
    columns = [np.arange(size) < size // 2 for size in sizes]
    diffuse = np.where(columns[0][None, :, None], 0.0, paint) * np.ones((sizes[0], 1, 1))
    specular = np.where(columns[1][None, :, None], gold, 0.04) * np.ones((sizes[1], 1, 1))
    gloss = np.where(columns[1], 0.9, 0.3)[None, :, None] * np.ones((sizes[1], 1, 1))
    block = {
        "diffuseTexture": {"index": 0},
        "specularGlossinessTexture": {"index": 1},
        "glossinessFactor": 0.5,
    }
    shown = [picture(linear_to_srgb(diffuse)), picture(np.concatenate([linear_to_srgb(specular), gloss], axis=2))]
    material, outcome = look(tmp_path, textured(*shown, extensions={"KHR_materials_pbrSpecularGlossiness": block}))
    assert outcome.diagnostics == ()
    base = srgb_to_linear(texels_of(outcome, material.base_color_texture))
    surface = texels_of(outcome, material.metallic_texture)
    assert material.metallic_texture is not None
    assert material.roughness_texture is not None
    assert (material.metallic_texture.channel, material.roughness_texture.channel) == ("b", "g")
    left, right = base[0, 0], base[0, -1]
    np.testing.assert_allclose(left, gold, atol=0.02)
    np.testing.assert_allclose(right, metallic_from_specular(paint, np.full(3, 0.04))[0], atol=0.02)
    np.testing.assert_allclose(surface[0, [0, -1], 2], [1.0, 0.0], atol=0.02)
    np.testing.assert_allclose(surface[0, [0, -1], 1], [1 - 0.5 * 0.9, 1 - 0.5 * 0.3], atol=0.01)
    assert material.origins["metallic_texture"].source == "inferred"


def test_pictures_that_are_sampled_apart_stay_and_the_surface_is_a_dielectric(tmp_path: Path):
    moved = {"index": 1, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    block = {
        "diffuseFactor": [0.5, 0.4, 0.3, 1],
        "diffuseTexture": {"index": 0},
        "glossinessFactor": 0.8,
        "specularGlossinessTexture": moved,
    }
    file = textured(png("RGB", 1), png("RGBA", 2), extensions={"KHR_materials_pbrSpecularGlossiness": block})
    material, _ = look(tmp_path, file)
    assert (material.base_color, material.metallic, material.roughness) == ((0.5, 0.4, 0.3), 0.0, 1.0)
    rough = material.roughness_texture
    assert rough is not None
    assert (rough.channel, rough.scale, rough.bias) == ("a", -0.8, 1.0)  # 1 - glossiness


@pytest.mark.parametrize(
    ("scales", "thickness", "source", "confidence"),
    [([1.0], 0.5, "declared", 1.0), ([0.01], 0.005, "declared", 1.0), ([0.01, 0.03, 0.02], 0.01, "inferred", 0.5)],
)
def test_the_thickness_of_a_volume_follows_the_scale_of_its_nodes(
    scales: list[float], thickness: float, source: str, confidence: float, tmp_path: Path
) -> None:
    """In the frame of the mesh it is half a unit; the attenuation distance is in metres whatever the nodes."""
    volume = {"thicknessFactor": 0.5, "attenuationDistance": 2.0}
    file = textured(extensions={"KHR_materials_volume": volume})
    file.doc["nodes"] = [{"mesh": 0, "scale": [scale] * 3} for scale in scales]
    file.doc["scenes"] = [{"nodes": list(range(len(scales)))}]
    material, _ = look(tmp_path, file)
    assert material.volume is not None
    assert material.volume.thickness == pytest.approx(thickness)
    assert material.volume.attenuation_distance == 2.0
    origin = material.origins["volume.thickness"]
    assert (origin.source, origin.confidence) == (source, confidence)
