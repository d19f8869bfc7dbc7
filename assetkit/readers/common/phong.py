"""Converts Phong material values (MTL, COLLADA) to metallic-roughness values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from schemas.appearance.conversions import srgb_to_linear
from schemas.appearance.material import LinearRGB, Origin

PHONG = "Blinn-Phong exponent as Beckmann width (Walter et al. 2007)"
PHONG_CONFIDENCE = 0.6  # Exporters write exponents of their own defaults, and lobes differ.
BARE_METAL = Origin("inferred", "black diffuse colour under a bright specular one: a bare metal", PHONG_CONFIDENCE)
_MOST_BLACK, _LEAST_BRIGHT = 0.03, 0.25  # linear; paints reflect more and highlights of dielectrics less


def bare_metal(diffuse: Sequence[float] | None, specular: Sequence[float] | None) -> LinearRGB | None:
    """The linear base colour of a surface that is stated as black (display values) and mirrors a bright colour.

    Else None: a bright specular colour over a paint says how strong a highlight was drawn, and no more.
    """
    if diffuse is None or specular is None:
        return None
    paint, mirror = linear_rgb(diffuse), linear_rgb(specular)
    return mirror if max(paint) <= _MOST_BLACK and max(mirror) >= _LEAST_BRIGHT else None


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
