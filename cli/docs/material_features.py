"""The page `docs/reference/material-features.md` from the table of material features."""

from __future__ import annotations

from itertools import groupby

from assetkit.readers.material_features import TREATMENTS, Feature, material_features

_INTRODUCTION = """# Material features of source formats

What becomes of each feature of a material. Fields are those of `schemas.appearance.material.Material`, which the record
lists in `appearance.render_materials` with their evidence; `sheen.color` is a field of a layer.
[How they are shown](../explanation/appearance.md).

"""
_TITLES = {
    "gltf": "glTF 2.0 (.gltf, .glb, and .blend through it)",
    "mtl": "MTL (.obj)",
    "dae": "COLLADA, profile_COMMON",
    "ply": "PLY",
    "usd": "USD surface shaders",
    "urdf": "URDF",
    "mjcf": "MJCF",
}
_NOTES = {
    "gltf": "Material variants have their default. Geometry packed by Draco, meshopt or quantization is unpacked.",
    "ply": "Vertex and face colours become colours of the mesh.",
    "usd": "UsdPreviewSurface counts where a material has several surfaces; layers that it cannot state come from the "
    "others. Colours of the mesh (displayColor) are kept with the mesh.",
}
_PICTURES = """## Pictures
PNG and JPEG keep their bytes. WebP, BMP, TGA, GIF and TIFF are decoded and written as PNG. KTX2 and Basis Universal,
DDS, OpenEXR, HDR, PSD, PVR, JPEG 2000, SVG, AVIF and HEIF are refused with `asset/unsupported-texture`; the material
keeps its other values. Normal maps have green up (OpenGL's way). MTL, COLLADA and MJCF leave the way open: it is found
from the picture, where slopes of heights can be integrated in one way only, and maps of the other way are turned.
"""


def page() -> str:
    """The page as text."""
    treatments = "".join(f"- **{name}**: {meaning}\n" for name, meaning in TREATMENTS.items())
    tables = [
        _table(format_name, tuple(rows))
        for format_name, rows in groupby(material_features(), lambda feature: feature.format)
    ]
    return _INTRODUCTION + treatments + "\n" + "".join(tables) + _PICTURES


def _table(format_name: str, features: tuple[Feature, ...]) -> str:
    note = f"{_NOTES[format_name]}\n\n" if format_name in _NOTES else ""
    head = f"## {_TITLES[format_name]}\n{note}| feature | treatment | becomes | how |\n|---|---|---|---|\n"
    return head + "".join(_row(feature) for feature in features) + "\n"


def _row(feature: Feature) -> str:
    return f"| {feature.name} | {feature.treatment} | `{feature.becomes}` | {feature.how} |\n"
