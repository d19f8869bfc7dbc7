"""Made glTF samples: a ball of 0.1 m radius for each feature of glTF materials, as bytes of a .glb file by name."""

from __future__ import annotations

import io
import json
import struct
from typing import Any

import numpy as np
from PIL import Image

from schemas.arrays import AnyFloatArray, FloatArray

RINGS, SEGMENTS = 48, 96
RADIUS_M = 0.1
_TEXTURE_PX = 256
_CHECKS = 8
_ARRAY_BUFFER_FLOAT, _UNSIGNED_INT = 5126, 5125
_GLTF, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942


def _plain(color: tuple[float, float, float], metallic: float, roughness: float, alpha: float = 1.0) -> dict[str, Any]:
    """A material of these factors."""
    factors = {"baseColorFactor": [*color, alpha], "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"pbrMetallicRoughness": factors}


def _textured(number: int, roughness: float, **transform: Any) -> dict[str, Any]:
    """A dielectric with a picture as base colour."""
    placed = {"extensions": {"KHR_texture_transform": transform}} if transform else {}
    use = {"index": number, **placed}
    return {"pbrMetallicRoughness": {"baseColorTexture": use, "metallicFactor": 0.0, "roughnessFactor": roughness}}


def _layer(name: str, **values: Any) -> dict[str, Any]:
    """An extension of that name, with its values."""
    return {f"KHR_materials_{name}": values}


_CHECKS_MAP, _ORM_MAP, _NORMAL_MAP, _HOLES_MAP = range(4)  # textures of every made file
_VOLUME = _layer("volume", thicknessFactor=0.2, attenuationColor=[0.6, 0.9, 0.7], attenuationDistance=0.2)
# By name: the glTF material, a feature each.
MATERIALS: dict[str, dict[str, Any]] = {
    "made_painted": _plain((0.6, 0.1, 0.08), 0.0, 0.45),
    "made_metal": _plain((0.7, 0.6, 0.4), 1.0, 0.35),
    "made_mirror": _plain((0.9, 0.9, 0.9), 1.0, 0.05),
    "made_checks": _textured(_CHECKS_MAP, 0.6),
    "made_transformed": _textured(_CHECKS_MAP, 0.6, offset=[0.1, 0.2], rotation=0.5, scale=[2.0, 3.0]),
    "made_orm": {
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.55, 1.0],
            "metallicRoughnessTexture": {"index": _ORM_MAP},
        }
    },
    "made_bumps": {**_plain((0.3, 0.4, 0.6), 0.0, 0.4), "normalTexture": {"index": _NORMAL_MAP}},
    "made_weak_bumps": {**_plain((0.3, 0.6, 0.4), 0.0, 0.4), "normalTexture": {"index": _NORMAL_MAP, "scale": 0.4}},
    "made_glow": {
        **_plain((0.1, 0.1, 0.1), 0.0, 1.0),
        "emissiveFactor": [0.3, 0.15, 0.0],
        "extensions": _layer("emissive_strength", emissiveStrength=2.0),
    },
    "made_glow_map": {
        **_plain((0.1, 0.1, 0.1), 0.0, 1.0),
        "emissiveFactor": [0.8, 0.8, 0.8],
        "emissiveTexture": {"index": _CHECKS_MAP},
    },
    "made_unlit": {**_textured(_CHECKS_MAP, 0.9), "extensions": _layer("unlit")},
    "made_ior": {**_plain((0.2, 0.2, 0.25), 0.0, 0.2), "extensions": _layer("ior", ior=1.8)},
    "made_specular": {
        **_plain((0.2, 0.2, 0.25), 0.0, 0.2),
        "extensions": _layer("specular", specularFactor=0.3, specularColorFactor=[1.0, 0.6, 0.3]),
    },
    "made_sheen": {
        **_plain((0.15, 0.05, 0.2), 0.0, 0.8),
        "extensions": _layer("sheen", sheenColorFactor=[0.8, 0.5, 0.9], sheenRoughnessFactor=0.4),
    },
    "made_anisotropic": {
        **_plain((0.7, 0.7, 0.72), 1.0, 0.4),
        "extensions": _layer("anisotropy", anisotropyStrength=0.8),
    },
    "made_iridescent": {
        **_plain((0.3, 0.3, 0.3), 1.0, 0.2),
        "extensions": _layer("iridescence", iridescenceFactor=1.0),
    },
    "made_cutout": {**_textured(_HOLES_MAP, 0.7), "alphaMode": "MASK", "doubleSided": True},
    "made_blend": {**_plain((0.7, 0.2, 0.1), 0.0, 0.6, alpha=0.5), "alphaMode": "BLEND"},
    "made_coat": {
        **_plain((0.05, 0.1, 0.4), 0.0, 0.6),
        "extensions": _layer("clearcoat", clearcoatFactor=1.0, clearcoatRoughnessFactor=0.05),
    },
    "made_coat_map": {
        **_plain((0.4, 0.05, 0.05), 0.0, 0.6),
        "extensions": _layer(
            "clearcoat",
            clearcoatFactor=1.0,
            clearcoatRoughnessFactor=0.5,
            clearcoatRoughnessTexture={"index": _ORM_MAP},
        ),
    },
    "made_coat_bumps": {
        **_plain((0.05, 0.3, 0.1), 0.0, 0.6),
        "extensions": _layer("clearcoat", clearcoatFactor=1.0, clearcoatNormalTexture={"index": _NORMAL_MAP}),
    },
    "made_thin_glass": {
        **_plain((1.0, 1.0, 1.0), 0.0, 0.0),
        "extensions": _layer("transmission", transmissionFactor=1.0),
    },
    "made_glass": {
        **_plain((1.0, 1.0, 1.0), 0.0, 0.0),
        "extensions": {**_layer("transmission", transmissionFactor=1.0), **_VOLUME},
    },
}


def made_glb(name: str) -> bytes:
    """A ball of 10 cm with that material; y is up."""
    points, normals, uv, triangles = _ball()
    pictures = (_checks(), _metal_and_roughness(), _bumps(), _holes())
    blocks = [points, normals, uv, triangles, *pictures]
    data, views = bytearray(), []
    for block in blocks:
        data += bytes(-len(data) % 4)
        raw = block if isinstance(block, bytes) else block.tobytes()
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(raw)})
        data += raw
    data += bytes(-len(data) % 4)
    material = MATERIALS[name]
    text = json.dumps(material)
    used = sorted({word for word in text.split('"') if word.startswith("KHR_")})
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}
        ],
        "materials": [{"name": name, **material}],
        "accessors": [
            _accessor(0, points, "VEC3") | {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()},
            _accessor(1, normals, "VEC3"),
            _accessor(2, uv, "VEC2"),
            {"bufferView": 3, "componentType": _UNSIGNED_INT, "count": int(triangles.size), "type": "SCALAR"},
        ],
        "images": [{"bufferView": 4 + k, "mimeType": "image/png"} for k in range(len(pictures))],
        "textures": [{"source": k} for k in range(len(pictures))],
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
        **({"extensionsUsed": used} if used else {}),
    }
    head = json.dumps(document).encode()
    head += b" " * (-len(head) % 4)
    chunks = struct.pack("<II", len(head), _JSON) + head + struct.pack("<II", len(data), _BIN) + bytes(data)
    return struct.pack("<III", _GLTF, 2, 12 + len(chunks)) + chunks


def _accessor(view: int, values: FloatArray, kind: str) -> dict[str, Any]:
    return {"bufferView": view, "componentType": _ARRAY_BUFFER_FLOAT, "count": len(values), "type": kind}


def _ball() -> tuple[Any, Any, Any, Any]:
    """Points, normals, texture coordinates and triangles of a ball that stands on y = 0."""
    v, u = np.meshgrid(np.linspace(0.0, 1.0, RINGS + 1), np.linspace(0.0, 1.0, SEGMENTS + 1), indexing="ij")
    polar, round_ = np.pi * v.ravel(), 2.0 * np.pi * u.ravel()
    normals = np.stack([np.sin(polar) * np.sin(round_), np.cos(polar), np.sin(polar) * np.cos(round_)], axis=1)
    points = RADIUS_M * (normals + np.array([0.0, 1.0, 0.0]))
    at = np.arange((RINGS + 1) * (SEGMENTS + 1)).reshape(RINGS + 1, SEGMENTS + 1)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    lower = np.stack([a, b, c], axis=1)[:-SEGMENTS]
    triangles = np.concatenate([lower, np.stack([a, c, d], axis=1)[SEGMENTS:]])
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    return points.astype("<f4"), normals.astype("<f4"), uv.astype("<f4"), triangles.astype("<u4")


def _png(pixels: AnyFloatArray) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(np.round(255.0 * np.clip(pixels, 0.0, 1.0)).astype(np.uint8)).save(buffer, "PNG")
    return buffer.getvalue()


def _grid() -> tuple[FloatArray, FloatArray]:
    """Coordinates of texel centres, 0 to 1: along u, along v."""
    at = (np.arange(_TEXTURE_PX) + 0.5) / _TEXTURE_PX
    v, u = np.meshgrid(at, at, indexing="ij")
    return u, v


def _checks() -> bytes:
    u, v = _grid()
    odd = (np.floor(_CHECKS * u) + np.floor(_CHECKS * v)) % 2.0
    return _png(np.stack([0.2 + 0.7 * odd, 0.3 + 0.4 * u, 0.8 - 0.5 * v], axis=2))


def _metal_and_roughness() -> bytes:
    """Roughness in green rises along u; metal in blue by bands of v."""
    u, v = _grid()
    return _png(np.stack([np.ones_like(u), 0.15 + 0.8 * u, np.floor(4.0 * v) % 2.0], axis=2))


def _bumps() -> bytes:
    """Normals of sin waves along both directions, green up."""
    u, v = _grid()
    waves = 2.0 * np.pi * _CHECKS
    x, y = 0.5 * np.cos(waves * u), -0.5 * np.cos(waves * v)
    normal = np.stack([-x, y, np.ones_like(x)], axis=2)
    return _png(0.5 + 0.5 * normal / np.linalg.norm(normal, axis=2, keepdims=True))


def _holes() -> bytes:
    u, v = _grid()
    solid = ((_CHECKS * u) % 1.0 - 0.5) ** 2 + ((_CHECKS * v) % 1.0 - 0.5) ** 2 > 0.09
    return _png(np.stack([0.7 * np.ones_like(u), 0.5 * np.ones_like(u), 0.2 + 0.3 * u, solid * 1.0], axis=2))
