"""glTF materials and textures: what is mapped, what is kept, which image is taken, how uvs are transformed."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from assetkit.readers.gltf.textures import usd_transform
from schemas.appearance.conversions import metallic_from_specular
from schemas.appearance.material import Material
from schemas.diagnostics import InvalidInput, Severity
from schemas.model import Model
from schemas.outcome import Outcome
from tests.support.gltf_files import POINTS, GltfFile, model, png, read, tetrahedron

numbers = st.floats(-3, 3)
pairs = st.tuples(numbers, numbers)
fractions = st.floats(0, 1)
colors = st.tuples(fractions, fractions, fractions)


def textured(*textures: bytes, **material: Any) -> GltfFile:
    file = tetrahedron()
    file.doc["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = file.accessor(POINTS[:, :2].copy())
    file.doc["meshes"][0]["primitives"][0]["material"] = 0
    for data in textures:
        file.image(data)
    file.doc["materials"] = [{"name": "m", **material}]
    return file


def look(folder: Path, file: GltfFile) -> tuple[Material, Outcome[Model]]:
    outcome = read(folder, file.glb())
    assert outcome.value is not None
    return outcome.value.materials[0], outcome


BASE_TEXTURE: dict[str, Any] = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}


# UV transforms.


@given(pairs, numbers, pairs, st.lists(pairs, min_size=1, max_size=5))
def test_transforms_sample_the_same_texel(scale, angle, offset, uvs):
    """Map uvs in glTF's v-down plane, and flipped ones with the USD values in the v-up plane: flips of one another."""
    down = np.array(uvs)
    c, s = np.cos(angle), np.sin(angle)
    # three.js Matrix3.setUvTransform and Blender's importer both have this sign of the angle.
    mapped = (down * scale) @ np.array([[c, s], [-s, c]]).T + offset
    usd_scale, usd_angle, usd_offset = usd_transform(scale, angle, offset)
    up = np.stack([down[:, 0], 1 - down[:, 1]], axis=1)
    c, s = np.cos(usd_angle), np.sin(usd_angle)
    # UsdTransform2d: scale, rotate counter-clockwise, translate.
    usd_mapped = (up * usd_scale) @ np.array([[c, -s], [s, c]]).T + usd_offset
    np.testing.assert_allclose(usd_mapped, np.stack([mapped[:, 0], 1 - mapped[:, 1]], axis=1), atol=1e-9)


def test_a_transform_reaches_the_texture_use(tmp_path):
    transform = {"offset": [0.25, 0.5], "rotation": np.pi / 2, "scale": [2, 3], "texCoord": 0}
    info = {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": transform}}
    file = textured(png(), pbrMetallicRoughness={"baseColorTexture": info})
    file.doc["samplers"] = [{"wrapS": 33071, "wrapT": 33648}]
    file.doc["textures"][0]["sampler"] = 0
    use = look(tmp_path, file)[0].base_color_texture
    assert use is not None
    assert (use.uv_set, use.wrap_s, use.wrap_t) == (0, "clamp", "mirror")
    assert (use.uv_scale, use.uv_rotation_rad) == ((2, 3), np.pi / 2)
    np.testing.assert_allclose(use.uv_offset, (3.25, 0.5), atol=1e-12)


# Core properties.


def test_all_core_properties(tmp_path):
    file = textured(
        png("RGBA", 1),
        png("RGB", 2),
        pbrMetallicRoughness={
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
            "baseColorTexture": {"index": 0},
            "metallicFactor": 0.6,
            "roughnessFactor": 0.7,
            "metallicRoughnessTexture": {"index": 1},
        },
        normalTexture={"index": 1, "scale": 0.5},
        occlusionTexture={"index": 1, "strength": 0.25},
        emissiveTexture={"index": 1},
        emissiveFactor=[0.5, 0, 0],
        alphaMode="MASK",
        alphaCutoff=0.3,
        doubleSided=True,
        extras={"note": 1},
    )
    material, outcome = look(tmp_path, file)
    assert [diagnostic.code for diagnostic in outcome.diagnostics] == ["asset/material-extension-fallback"]
    assert material.base_color == (0.1, 0.2, 0.3)
    assert (material.opacity, material.alpha_mode, material.alpha_cutoff) == (0.4, "mask", 0.3)
    assert (material.metallic, material.roughness, material.normal_scale) == (0.6, 0.7, 0.5)
    assert (material.emissive, material.double_sided) == ((0.5, 0, 0), True)
    uses = {
        name: (use.texture, use.channel, use.scale, use.bias)
        for name in ("base_color", "opacity", "metallic", "roughness", "normal", "occlusion", "emissive")
        if (use := getattr(material, f"{name}_texture"))
    }
    assert uses == {
        "base_color": ("image_0", "rgb", 1, 0),
        "opacity": ("image_0", "a", 1, 0),
        "metallic": ("image_1", "b", 1, 0),
        "roughness": ("image_1", "g", 1, 0),
        "normal": ("image_1", "rgb", 1, 0),
        "occlusion": ("image_1", "r", 0.25, 0.75),
        "emissive": ("image_1", "rgb", 1, 0),
    }
    assert material.unmapped == {"extras": {"note": 1}}
    assert outcome.value is not None
    assert {t.name: t.data for t in outcome.value.textures} == {"image_0": png("RGBA", 1), "image_1": png("RGB", 2)}


def test_defaults_are_those_of_the_standard(tmp_path):
    material, _ = look(tmp_path, textured())
    assert (material.base_color, material.metallic, material.roughness) == ((1, 1, 1), 1, 1)
    assert (material.opacity, material.alpha_mode, material.emissive) == (1, "opaque", (0, 0, 0))


def test_opaque_ignores_alpha(tmp_path):
    file = textured(
        png("RGBA"), pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0], "baseColorTexture": {"index": 0}}
    )
    material, _ = look(tmp_path, file)
    assert (material.opacity, material.opacity_texture) == (1.0, None)


def test_values_out_of_range_are_clamped_and_noted(tmp_path):
    file = textured(pbrMetallicRoughness={"metallicFactor": 2, "baseColorFactor": [1, -1, 0, 1]})
    material, outcome = look(tmp_path, file)
    assert (material.metallic, material.base_color) == (1, (1, 0, 0))
    assert [d.code for d in outcome.diagnostics] == ["asset/invalid-material-value"] * 2


def test_only_used_materials_and_images_are_loaded(tmp_path):
    file = textured(png("RGB", 1), b"never opened", **BASE_TEXTURE)
    file.doc["materials"].insert(0, {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}})
    file.doc["meshes"][0]["primitives"][0]["material"] = 1
    value = model(tmp_path, file)
    assert [m.name for m in value.materials] == ["m"]
    assert value.meshes[0].material == 0
    assert [t.data for t in value.textures] == [png("RGB", 1)]


# Extensions.


def test_extensions_with_a_field_are_mapped(tmp_path):
    extensions = {
        "KHR_materials_ior": {"ior": 1.33},
        "KHR_materials_emissive_strength": {"emissiveStrength": 2.0},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25},
    }
    material, outcome = look(tmp_path, textured(emissiveFactor=[0.1, 0.2, 0.4], extensions=extensions))
    assert (material.ior, material.clearcoat, material.clearcoat_roughness) == (1.33, 0.5, 0.25)
    np.testing.assert_allclose(material.emissive, (0.2, 0.4, 0.8))
    assert (material.unmapped, outcome.diagnostics) == ({}, ())


def test_extensions_without_a_field_are_kept_verbatim_and_said_once(tmp_path):
    extensions = {"ACME_glow": {"deep": [1, {"x": None}]}, "KHR_materials_ior": {"ior": 0}, "ACME_dust": {}}
    material, outcome = look(tmp_path, textured(extensions=extensions))
    assert material.unmapped == extensions
    (diagnostic,) = outcome.diagnostics
    assert (diagnostic.code, diagnostic.severity) == ("asset/material-extension-fallback", Severity.INFO)
    assert diagnostic.where.prim == "/materials/0"
    assert outcome.repairs == ()


@given(colors)
def test_dielectrics_keep_their_diffuse_colour(color):
    base, metallic = metallic_from_specular(np.array(color), np.full(3, 0.04))
    assert metallic == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(base, color, atol=1e-6)


@given(st.tuples(*[st.floats(0.3, 1)] * 3))
def test_metals_keep_their_specular_colour(color):
    base, metallic = metallic_from_specular(np.zeros(3), np.array(color))
    assert metallic == pytest.approx(1.0)
    np.testing.assert_allclose(base, color, atol=1e-6)


@given(colors, colors)
def test_specular_conversion_stays_in_range(diffuse, specular):
    base, metallic = metallic_from_specular(np.array(diffuse), np.array(specular))
    assert 0.0 <= metallic <= 1.0
    assert all(0.0 <= c <= 1.0 for c in base)


# Images.


def test_one_image_is_one_texture_however_often_it_is_named(tmp_path):
    file = textured(png(), png(), **BASE_TEXTURE, emissiveTexture={"index": 1})
    file.doc["textures"].append({"source": 0})
    file.doc["materials"][0]["normalTexture"] = {"index": 2}
    material, outcome = look(tmp_path, file)
    assert outcome.value is not None
    assert len(outcome.value.textures) == 1
    uses = material.base_color_texture, material.emissive_texture, material.normal_texture
    assert {u.texture for u in uses if u} == {"image_0"}
    assert None not in uses


def test_texture_names_are_unique_and_keep_the_source_name(tmp_path):
    file = textured(png("RGB", 1), png("RGB", 2), **BASE_TEXTURE, emissiveTexture={"index": 1})
    for image in file.doc["images"]:
        image["name"] = "Holz hell"
    value = model(tmp_path, file)
    assert [t.name for t in value.textures] == ["Holz hell", "Holz hell_2"]


def test_external_images(tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "wood color.PNG").write_bytes(png())
    file = textured(**BASE_TEXTURE)
    file.doc["textures"], file.doc["images"] = [{"source": 0}], [{"uri": "maps/Wood%20color.png"}]
    (texture,) = model(tmp_path, file).textures
    assert (texture.name, texture.data) == ("Wood color", png())
    file.doc["images"] = [{"uri": "../secret.png"}]
    with pytest.raises(InvalidInput) as caught:
        model(tmp_path, file)
    assert caught.value.diagnostic.code == "asset/path-escape"


@pytest.mark.parametrize(
    ("image", "code", "name"),
    [
        ({"uri": "absent.png"}, "asset/missing-texture", "missing_texture"),
        ({"uri": "data:image/png;base64,iVBORw0KGgo="}, "asset/corrupt-texture", "corrupt_texture"),
        ({"uri": "data:image/ktx2;base64,q0tUWCAyMLs="}, "asset/unsupported-texture", "unsupported_texture"),
    ],
)
def test_lost_pictures_leave_the_scalar_colour(tmp_path, image, code, name):
    file = textured(pbrMetallicRoughness={"baseColorFactor": [0.1, 0.2, 0.3, 1], "baseColorTexture": {"index": 0}})
    file.doc["textures"], file.doc["images"] = [{"source": 0}], [image]
    material, outcome = look(tmp_path, file)
    assert (material.base_color, material.base_color_texture) == ((0.1, 0.2, 0.3), None)
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [(code, Severity.WARNING)]
    assert [(r.name, r.code) for r in outcome.repairs] == [(name, code)]


KTX2 = {"uri": "data:image/ktx2;base64,q0tUWCAyMLs="}


@pytest.mark.parametrize(
    ("fallback", "codes"),
    [
        (None, ["asset/unsupported-texture"]),
        ({"uri": "absent.png"}, ["asset/missing-texture", "asset/unsupported-texture"]),
        ("png", []),
    ],
)
def test_basisu_uses_its_fallback(tmp_path, fallback, codes):
    file = textured(**BASE_TEXTURE)
    texture: dict[str, Any] = {"extensions": {"KHR_texture_basisu": {"source": 0}}}
    file.doc["textures"] = [texture]
    file.doc["images"] = [KTX2]
    if fallback is not None:
        (tmp_path / "a.png").write_bytes(png())
        file.doc["images"].append({"uri": "a.png"} if fallback == "png" else fallback)
        texture["source"] = 1
    material, outcome = look(tmp_path, file)
    assert [d.code for d in outcome.diagnostics] == codes
    assert (material.base_color_texture is None) == bool(codes)


def test_webp_becomes_png_without_loss(tmp_path):
    buffer = io.BytesIO()
    Image.open(io.BytesIO(png())).save(buffer, "WEBP", lossless=True)
    file = textured(buffer.getvalue(), **BASE_TEXTURE)
    file.doc["textures"] = [{"extensions": {"EXT_texture_webp": {"source": 0}}}]
    file.doc["extensionsRequired"] = ["EXT_texture_webp"]
    (texture,) = model(tmp_path, file).textures
    assert texture.extension == "png"
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(texture.data))), np.asarray(Image.open(io.BytesIO(png()))))
