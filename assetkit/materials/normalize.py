"""Render materials clamped to the ranges that UsdPreviewSurface allows, and the appearance section of the record.

Every changed value is reported with its old and new value; uses of textures that the model lacks are dropped.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace

from assetkit.materials.surface_colours import surface_colours
from assetkit.stage import Appearance
from schemas.appearance.material import Material, TextureUse
from schemas.appearance.record import AppearanceSection
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import Model
from schemas.outcome import Outcome, Repair

STAGE = "appearance"
_UNIT_RANGE = ("metallic", "roughness", "opacity", "alpha_cutoff", "clearcoat", "clearcoat_roughness", "transmission")

_COLORS = ("base_color", "emissive")


def normalize(model: Model) -> Outcome[Appearance]:
    """The materials of `model` within their ranges, without uses of textures that are not there."""
    known = {t.name for t in model.textures}
    diagnostics: list[Diagnostic] = []
    repairs: list[Repair] = []
    materials = []
    for material in model.materials:
        clean, changed = _within_range(material)
        if changed:
            diagnostics += [_out_of_range(material, *change) for change in changed]
            repairs.append(
                Repair(
                    name="invalid_material_value",
                    code="asset/invalid-material-value",
                    stage=STAGE,
                    before={name: str(old) for name, old, _ in changed},
                    after={name: str(new) for name, _, new in changed},
                )
            )
        materials.append(_with_known_textures(clean, known))
    used = sorted({use.texture for m in materials for use in m.texture_uses.values()})
    section = AppearanceSection(
        materials=tuple(m.name for m in materials),
        textures=tuple(used),
        colours=surface_colours(replace(model, materials=tuple(materials))),
        unmapped={m.name: m.unmapped for m in materials if m.unmapped},
    )
    return Outcome(Appearance(tuple(materials), section), tuple(diagnostics), tuple(repairs))


def _within_range(material: Material) -> tuple[Material, list[tuple[str, object, object]]]:
    """The material with scalars and colours clamped to 0..1, and `(field, old, new)` for each change.

    Emissive colours may exceed 1 (emissive strength); they only need to be finite and not negative.
    """
    changes: list[tuple[str, object, object]] = []
    for name in _UNIT_RANGE:
        old = getattr(material, name)
        new = _clamp(old, 1.0)
        if new != old:
            changes.append((name, old, new))
    for name in _COLORS:
        old = getattr(material, name)
        new = tuple(_clamp(c, math.inf if name == "emissive" else 1.0) for c in old)
        if new != old:
            changes.append((name, old, new))
    if not (math.isfinite(material.ior) and material.ior >= 1.0):
        changes.append(("ior", material.ior, 1.5))
    return replace(material, **{name: new for name, _, new in changes}), changes


def _clamp(value: float, high: float) -> float:
    return min(max(value, 0.0), high) if math.isfinite(value) else 0.0


def _out_of_range(material: Material, name: str, old: object, new: object) -> Diagnostic:
    return finding(
        "asset/invalid-material-value",
        f"{name} of material '{material.name}' is {old}, used as {new}",
        where=Location(prim=material.name),
        value=str(old),
        bound="0..1",
    )


def _with_known_textures(material: Material, known: set[str]) -> Material:
    """The material without uses of textures that could not be loaded; their loss was reported when reading."""
    lost = {
        f.name: None
        for f in fields(material)
        if isinstance(v := getattr(material, f.name), TextureUse) and v.texture not in known
    }
    return replace(material, **lost)
