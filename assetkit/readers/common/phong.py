"""Converts Phong material values (MTL, COLLADA) to metallic-roughness values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from schemas.appearance.conversions import srgb_to_linear
from schemas.appearance.material import LinearRGB, Material, Origin
from schemas.diagnostics import Diagnostic, Location, finding

_PHONG = "Blinn-Phong exponent as Beckmann width (Walter et al. 2007)"
PHONG_CONFIDENCE = 0.6  # Exporters write exponents of their own defaults, and lobes differ.
BARE_METAL = Origin("inferred", "black diffuse colour under a bright specular one: a bare metal", PHONG_CONFIDENCE)
_MODELS = frozenset({"shader", "illum"})
_MOST_BLACK, _LEAST_BRIGHT = 0.03, 0.25  # linear; paints reflect more and highlights of dielectrics less


def bare_metal(diffuse: Sequence[float] | None, specular: Sequence[float] | None) -> LinearRGB | None:
    """The linear base colour of a surface that is stated as black (display values) and mirrors a bright colour.

    Else None: a bright specular colour over a paint says how strong a highlight was drawn, and no more.
    """
    if diffuse is None or specular is None:
        return None
    paint, mirror = linear_rgb(diffuse), linear_rgb(specular)
    return mirror if max(paint) <= _MOST_BLACK and max(mirror) >= _LEAST_BRIGHT else None


def origins_of(
    material: Material,
    properties: Mapping[str, Sequence[str]],
    stated: Mapping[str, str],
    *,
    exponent: str,
    metal: bool,
) -> dict[str, Origin]:
    """The property behind each value of a Phong material, and how sure a conversion is.

    `properties` lists those from which each field is made, of which the first that is `stated` counts; `stated` gives
    its name in the file. `exponent` is that of the highlight, `metal` whether the surface was taken for a bare metal.
    """
    origins: dict[str, Origin] = {}
    for field, keys in properties.items():
        name = next((stated[key] for key in keys if key in stated), None)
        layer, _, value = field.rpartition(".")
        holder = getattr(material, layer) if layer else material
        if name is not None and holder is not None and getattr(holder, value) is not None:
            origins[field] = Origin("declared", name)
    if metal:
        origins["base_color"] = origins["metallic"] = BARE_METAL
    if "roughness" not in origins and material.roughness == 1.0:
        origins["roughness"] = Origin("inferred", "a surface without a highlight", PHONG_CONFIDENCE)
    elif "roughness" not in origins and exponent in stated:
        origins["roughness"] = Origin("inferred", f"{stated[exponent]}: {_PHONG}", PHONG_CONFIDENCE)
    return origins


def kept_in_record(materials: Sequence[Material], where: Location) -> tuple[Diagnostic, ...]:
    """One finding on the properties of `materials` that no field holds; the model of shading itself is none."""
    names = sorted({name for material in materials for name in material.unmapped} - _MODELS)
    if not names:
        return ()
    headline = f"{', '.join(names)} of materials kept in the record only"
    return (finding("asset/material-extension-fallback", headline, where=where, value=", ".join(names)),)


def roughness_from_exponent(exponent: float) -> float:
    """UsdPreviewSurface roughness in 0..1 for a Blinn-Phong exponent; negative exponents count as 0.

    Exponent n matches a Beckmann lobe of width a = sqrt(2 / (n + 2)) (Walter et al., "Microfacet Models for
    Refraction through Rough Surfaces", EGSR 2007), and UsdPreviewSurface squares roughness to get a.
    """
    return (2.0 / (max(exponent, 0.0) + 2.0)) ** 0.25


def linear_rgb(display: Sequence[float]) -> tuple[float, float, float]:
    """Linear RGB of a display colour; both formats leave the space open, and tools show the values as they are."""
    r, g, b = (float(c) for c in srgb_to_linear(np.asarray(display[:3])))
    return r, g, b


def ior_or_default(ior: float | None) -> float:
    """`ior` where it can be a solid's, else 1.5: exporters write 1 or 0 for "not set"."""
    return ior if ior is not None and 1.0 < ior <= 4.0 else 1.5


def unit_interval(value: float) -> float:
    """`value` clamped to 0..1."""
    return min(max(value, 0.0), 1.0)
