"""Values of materials limited to the ranges in which shaders are defined, layers included."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, NamedTuple

from schemas.appearance.material import Material

Limit = Callable[[Any], Any]


class Change(NamedTuple):
    """One value that was out of range: its field, of layers as "sheen.color", what it was and what it is now."""

    field: str
    old: object
    new: object
    bound: str


def limited(material: Material) -> tuple[Material, list[Change]]:
    """`material` with every value inside its range, and what that changed; layers that are absent stay absent."""
    changes: list[Change] = []
    for field, (limit, bound) in RANGES.items():
        layer, _, name = field.rpartition(".")
        owner = getattr(material, layer) if layer else material
        if owner is None:
            continue
        old = getattr(owner, name)
        new = limit(old)
        if new == old:
            continue
        changes.append(Change(field, old, new, bound))
        if layer:
            material = replace(material, **{layer: replace(owner, **{name: new})})
        else:
            material = replace(material, **{name: new})
    return material, changes


def _between(least: float, most: float, otherwise: float = 0.0) -> Limit:
    """Clamps to `least`..`most`; what is no number becomes `otherwise`."""
    return lambda value: min(max(value, least), most) if math.isfinite(value) else otherwise


def _each(limit: Limit) -> Limit:
    return lambda values: tuple(limit(value) for value in values)


def _at_least_one(otherwise: float) -> Limit:
    """An index of refraction; below 1 there is none."""
    return lambda value: value if math.isfinite(value) and value >= 1.0 else otherwise


def _length(value: float) -> float:
    """A length after which light has lost its share; without one, none is lost."""
    return value if value > 0.0 else math.inf


_UNIT = (_between(0.0, 1.0), "0..1")
_UNIT_COLOR = (_each(_between(0.0, 1.0)), "0..1")
_BRIGHT_COLOR = (_each(_between(0.0, math.inf)), ">= 0")  # emission, and reflections of KHR_materials_specular
_POSITIVE = (_between(0.0, math.inf), ">= 0")
_ANY = (_between(-math.inf, math.inf), "finite")
_STRENGTH = (_between(-math.inf, math.inf, otherwise=1.0), "finite")
RANGES: Final[dict[str, tuple[Limit, str]]] = {
    "metallic": _UNIT,
    "roughness": _UNIT,
    "opacity": _UNIT,
    "alpha_cutoff": _UNIT,
    "clearcoat": _UNIT,
    "clearcoat_roughness": _UNIT,
    "transmission": _UNIT,
    "base_color": _UNIT_COLOR,
    "emissive": _BRIGHT_COLOR,
    "normal_scale": _STRENGTH,
    "clearcoat_normal_scale": _STRENGTH,
    "ior": (_at_least_one(1.5), ">= 1"),
    "dispersion": _POSITIVE,
    "specular.weight": _UNIT,
    "specular.color": _BRIGHT_COLOR,
    "volume.thickness": _POSITIVE,
    "volume.attenuation_distance": (_length, "> 0"),
    "volume.attenuation_color": _UNIT_COLOR,
    "sheen.color": _UNIT_COLOR,
    "sheen.roughness": _UNIT,
    "anisotropy.strength": _UNIT,
    "anisotropy.rotation_rad": _ANY,
    "iridescence.factor": _UNIT,
    "iridescence.ior": (_at_least_one(1.3), ">= 1"),
    "iridescence.thickness_nm": (_each(_between(0.0, math.inf)), ">= 0"),
    "diffuse_transmission.factor": _UNIT,
    "diffuse_transmission.color": _UNIT_COLOR,
}
