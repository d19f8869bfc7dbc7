"""Render materials and textures as they are released, checked, and the appearance section of the record.

Every changed value is reported with its old and new value; uses of textures that the model lacks are dropped.
"""

from __future__ import annotations

from dataclasses import replace

from assetkit.materials.alpha_pictures import with_alpha_apart
from assetkit.materials.baked_lighting import baked_lighting, suspicion
from assetkit.materials.material_records import material_records
from assetkit.materials.normal_maps import GreenDirection, with_green_up
from assetkit.materials.ranges import Change, limited
from assetkit.materials.recovery.degraded import degraded_surfaces
from assetkit.materials.surface_colours import surface_colours
from assetkit.materials.texel_density import texel_density
from assetkit.materials.texture_budget import Resampled, within_budget
from assetkit.materials.texture_coordinates import check_coordinates
from assetkit.stage import Appearance
from schemas.appearance.material import Material, Origin, Texture
from schemas.appearance.record import AppearanceSection
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.evidence import Evidence
from schemas.model import Model
from schemas.outcome import Outcome, Repair

STAGE = "appearance"
_LENGTHS = ("volume.thickness", "volume.attenuation_distance")


def normalize(
    model: Model, meters_per_unit: Evidence[float] | None = None, max_texture: int | None = None
) -> Outcome[Appearance]:
    """The materials of `model` within their ranges, lengths in metres, and its textures within the budget.

    The points of `model` are in metres already; `meters_per_unit` is the unit of the lengths that materials state
    (None: metres), `max_texture` the most pixels a side of a texture (None: as they are).
    """
    pictures = {texture.name: texture for texture in model.textures}
    known = set(pictures)
    directions: dict[str, GreenDirection] = {}
    diagnostics: list[Diagnostic] = []
    repairs: list[Repair] = []
    materials: list[Material] = []
    for material in model.materials:
        clean, changes = limited(material)
        if changes:
            diagnostics += [_out_of_range(material, change) for change in changes]
            repairs.append(_clamped(changes))
        upright, ways = with_green_up(with_known_textures(clean, known), pictures, directions)
        for field, way in ways.items():
            if way.green == "down":
                diagnostics.append(_green_down(material, field, way.correlation))
                repairs += _turning(material, field)
        materials.append(in_metres(upright, meters_per_unit))
    textures, reduced = within_budget(tuple(pictures.values()), materials, max_texture)
    split, pictures = with_alpha_apart(materials, {texture.name: texture for texture in textures})
    diagnostics += [_smaller(change, max_texture) for change in reduced]
    repairs += [_resampling(change) for change in reduced]
    released = replace(model, materials=split, textures=tuple(pictures.values()))
    section, notes = appearance_section(released)
    return Outcome(Appearance(released.materials, released.textures, section), (*diagnostics, *notes), tuple(repairs))


def with_known_textures(material: Material, known: set[str]) -> Material:
    """The material without uses of textures that could not be loaded; their loss was reported when reading."""
    for field, use in material.texture_uses.items():
        if use.texture not in known:
            material = material.with_value(field, None)
    return material


def in_metres(material: Material, meters_per_unit: Evidence[float] | None) -> Material:
    """The material with the lengths of its volume in metres; their origins say so."""
    if material.volume is None or meters_per_unit is None or meters_per_unit.value == 1.0:
        return material
    scale = meters_per_unit.value
    origins = dict(material.origins)
    for field in _LENGTHS:
        if field in origins:
            stated = origins[field]
            method = f"{stated.method}, times {scale:g} m per unit"
            origins[field] = Origin(stated.source, method, min(stated.confidence, meters_per_unit.confidence))
    volume = replace(
        material.volume,
        thickness=material.volume.thickness * scale,
        attenuation_distance=material.volume.attenuation_distance * scale,
    )
    return replace(material, volume=volume, origins=origins)


def appearance_section(model: Model) -> tuple[AppearanceSection, tuple[Diagnostic, ...]]:
    """The section on the materials and textures that are released, and what was found on them."""
    records, dropped = material_records(model)
    lighting = baked_lighting(model)
    section = AppearanceSection(
        materials=tuple(material.name for material in model.materials),
        textures=tuple(sorted({use.texture for m in model.materials for use in m.texture_uses.values()})),
        colours=surface_colours(model),
        unmapped={material.name: material.unmapped for material in model.materials if material.unmapped},
        render_materials=records,
        texels_per_m=texel_density(model),
        baked_lighting=lighting,
        degraded=degraded_surfaces(model),
    )
    return section, (*dropped, *check_coordinates(model), *suspicion(lighting))


def _green_down(material: Material, field: str, correlation: float) -> Diagnostic:
    outcome = "turned" if material.normal_green == "undeclared" else "kept, since the format defines it as up"
    headline = f"green of {field} of material '{material.name}' points down: {outcome}"
    where = Location(prim=material.name)
    return finding("asset/normal-map-green-down", headline, where=where, value=round(correlation, 2))


def _turning(material: Material, field: str) -> list[Repair]:
    if material.normal_green != "undeclared":
        return []
    before: dict[str, float | int | str] = {field: material.texture_uses[field].texture}
    return [Repair(name="turn_normal_map", code="asset/normal-map-green-down", stage=STAGE, before=before)]


def _out_of_range(material: Material, change: Change) -> Diagnostic:
    return finding(
        "asset/invalid-material-value",
        f"{change.field} of material '{material.name}' is {change.old}, used as {change.new}",
        where=Location(prim=material.name),
        value=str(change.old),
        bound=change.bound,
    )


def _clamped(changes: list[Change]) -> Repair:
    return Repair(
        name="invalid_material_value",
        code="asset/invalid-material-value",
        stage=STAGE,
        before={change.field: str(change.old) for change in changes},
        after={change.field: str(change.new) for change in changes},
    )


def _smaller(change: Resampled, most: int | None) -> Diagnostic:
    headline = f"texture '{change.old.name}' is {_size(change.old)}, released as {_size(change.new)}"
    value = max(change.old.width, change.old.height)
    return finding("asset/texture-resampled", headline, value=value, bound=most, unit="px")


def _resampling(change: Resampled) -> Repair:
    return Repair(
        name="resample_texture",
        code="asset/texture-resampled",
        stage=STAGE,
        before={"texture": change.old.name, "size": _size(change.old), "bytes": len(change.old.data)},
        after={"size": _size(change.new), "bytes": len(change.new.data), "filter": f"Lanczos, as {change.meaning}"},
    )


def _size(texture: Texture) -> str:
    return f"{texture.width} x {texture.height} px"
