"""Conversions between models of surfaces, for whole pictures at once."""

from __future__ import annotations

import math

import numpy as np

from schemas.arrays import AnyFloatArray, FloatArray

DIELECTRIC_F0 = 0.04  # reflectance of common dielectrics (index 1.5) at normal incidence
_MOST_REFLECTANCE = 0.25  # an index of 3: no dielectric reflects more
_BRIGHTNESS = np.array([0.299, 0.587, 0.114])


def metallic_from_specular(diffuse: FloatArray, specular: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Linear base colour (..., 3) and metalness (...) that look like linear diffuse and specular colours (..., 3).

    Source: KHR_materials_pbrSpecularGlossiness, the reference conversion: metalness m solves
    0.04 m^2 + (d k / 0.96 + s - 0.08) m + 0.04 - s = 0 for perceived brightnesses d, s and k = 1 - max(specular), and
    the base colour is blended from both. At the dielectric value itself black paint and black metal solve the equation
    alike: it is taken for paint.
    """
    diffuse, specular = np.clip(diffuse, 0.0, 1.0), np.clip(specular, 0.0, 1.0)
    d, s = (np.sqrt((colors**2) @ _BRIGHTNESS) for colors in (diffuse, specular))
    k = 1.0 - specular.max(axis=-1)
    a = DIELECTRIC_F0
    b = d * k / (1.0 - a) + s - 2.0 * a
    root = np.sqrt(np.maximum(b * b - 4.0 * a * (a - s), 0.0))
    metallic = np.where(s > a + 1e-9, np.clip((root - b) / (2.0 * a), 0.0, 1.0), 0.0)
    rest = metallic[..., None]
    paint = diffuse * k[..., None] / (1.0 - a) / np.maximum(1.0 - rest, 1e-6)
    metal = (specular - a * (1.0 - rest)) / np.maximum(rest, 1e-6)
    blend = rest * rest
    return np.clip(paint * (1.0 - blend) + metal * blend, 0.0, 1.0), metallic


def ior_of_reflectance(reflectance: float) -> float:
    """The index of refraction, at least 1, of a surface that reflects this share at normal incidence (Fresnel)."""
    root = math.sqrt(min(max(reflectance, 0.0), _MOST_REFLECTANCE))
    return (1.0 + root) / (1.0 - root)


def reflectance_of_ior(ior: float) -> float:
    """The share that a surface of this index of refraction reflects at normal incidence (Fresnel)."""
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def srgb_to_linear(values: AnyFloatArray) -> FloatArray:
    """Display values in 0..1 as linear light (IEC 61966-2-1), same shape; values outside are clamped."""
    v = np.clip(np.asarray(values, dtype=np.float64), 0.0, 1.0)
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(values: AnyFloatArray) -> FloatArray:
    """Linear light in 0..1 as display values (IEC 61966-2-1), same shape; values outside are clamped."""
    v = np.clip(np.asarray(values, dtype=np.float64), 0.0, 1.0)
    return np.where(v <= 0.0031308, v * 12.92, 1.055 * v ** (1.0 / 2.4) - 0.055)
