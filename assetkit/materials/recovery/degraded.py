"""Which surfaces of a model state no appearance that can be trusted, why, and which of their values are open.

A value is trustworthy when the source declares it or it was measured, with more confidence than a default that the
standard of a format fills in. A light grey under a name that tools give is the exporter's default, whoever wrote it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assetkit.annotate.name_reading import read_name
from assetkit.materials.colour_names import colour_by_name, lab_of
from assetkit.taxonomy.words import words_of
from schemas.appearance.material import LinearRGB, Material
from schemas.appearance.record import DegradedReason, DegradedSurface
from schemas.evidence import BY_STANDARD
from schemas.model import Mesh, Model

RECOVERABLE: Final = ("base_color", "metallic", "roughness", "ior", "transmission")
# Names that tools give to new materials, beside those that `read_name` calls uninformative.
_TOOL_NAMES: Final = frozenset(
    (
        "lambert",
        "blinn",
        "phong",
        "shader",
        "shading",
        "initial",
        "group",
        "sg",
        "fx",
        "display",
        "color",
        "none",
        "surface",
    )
)
# CIELAB: greys of exporters (0.8, 0.64 and 0.5 in display or linear values, and white) are lighter and duller.
_MOST_CHROMA: Final = 3.0
_LEAST_LIGHTNESS: Final = 50.0


@dataclass(frozen=True)
class DegradedMaterial:
    """A material of the model by index, None for meshes without one; `fields` may be filled in, no others."""

    index: int | None
    reason: DegradedReason
    fields: tuple[str, ...]


def degraded_materials(model: Model) -> tuple[DegradedMaterial, ...]:
    """The degraded materials that meshes of `model` use, in the order of the materials, meshes without any last.

    Vertex colours that are not one default grey state the colour of their mesh: a material counts as degraded only
    where some mesh has none.
    """
    uncoloured = {mesh.material for mesh in model.meshes if len(mesh.triangles) and not states_colours(mesh)}
    known = {texture.name for texture in model.textures}
    results: list[DegradedMaterial] = []
    for index, material in enumerate(model.materials):
        reason = degradation(material, known) if index in uncoloured else None
        if reason is not None and (fields := open_fields(material, reason)):
            results.append(DegradedMaterial(index, reason, fields))
    if None in uncoloured:
        results.append(DegradedMaterial(None, DegradedReason.NO_MATERIAL, RECOVERABLE))
    return tuple(results)


def degraded_surfaces(model: Model) -> tuple[DegradedSurface, ...]:
    """The same, as the record has them, with the ids of the meshes."""
    return tuple(
        DegradedSurface(
            material="" if degraded.index is None else model.materials[degraded.index].name,
            meshes=tuple(mesh.id for mesh in degraded_meshes(model, degraded)),
            reason=degraded.reason,
        )
        for degraded in degraded_materials(model)
    )


def degraded_meshes(model: Model, degraded: DegradedMaterial) -> tuple[Mesh, ...]:
    """The meshes of a degraded material whose vertices state no colour either."""
    return tuple(
        mesh
        for mesh in model.meshes
        if mesh.material == degraded.index and len(mesh.triangles) and not states_colours(mesh)
    )


def states_colours(mesh: Mesh) -> bool:
    """Whether vertex colours of a mesh state a colour: they vary, or are no default grey."""
    if mesh.colors is None or not len(mesh.colors):
        return False
    colours = np.asarray(mesh.colors[..., :3], dtype=np.float64).reshape(-1, 3)
    first = (float(colours[0, 0]), float(colours[0, 1]), float(colours[0, 2]))
    return bool(np.ptp(colours, axis=0).max() > 0.0) or not is_default_grey(first)


def degradation(material: Material, known_textures: set[str]) -> DegradedReason | None:
    """Why the colour of a material cannot be trusted; None where it can."""
    use = material.base_color_texture
    if use is not None and use.texture in known_textures:
        return None
    if use is not None or "base_color_texture" in material.lost_textures:
        return DegradedReason.LOST_TEXTURE
    if not trusted(material, "base_color"):
        return DegradedReason.UNSTATED_COLOUR
    if is_default_grey(material.base_color) and is_tool_name(material.name):
        return DegradedReason.DEFAULT_GREY
    return None


def open_fields(material: Material, reason: DegradedReason) -> tuple[str, ...]:
    """The fields of a degraded material that state nothing trustworthy.

    The colour beside a lost picture was its factor: white and greys mean nothing, a tone does. In an exporter's default
    metallic 0, or metallic and roughness both 1, are as little stated as the grey.
    """
    plain = is_default_grey(material.base_color)
    by_tool = reason is DegradedReason.DEFAULT_GREY and (
        material.metallic == 0.0 or material.metallic == material.roughness == 1.0
    )
    opened: list[str] = []
    for field in RECOVERABLE:
        if field != "ior" and f"{field}_texture" in material.texture_uses and field != "base_color":
            continue
        stated = trusted(material, field)
        if field == "base_color":
            stated = stated and not plain
        elif by_tool and field in ("metallic", "roughness"):
            stated = False
        if not stated:
            opened.append(field)
    return tuple(opened)


def trusted(material: Material, field: str) -> bool:
    """Whether the value of `field` was declared or measured, surer than a default of its format."""
    origin = material.origins.get(field)
    return origin is not None and origin.source in ("declared", "measured") and origin.confidence > BY_STANDARD


def is_default_grey(linear_rgb: LinearRGB) -> bool:
    """Whether a colour is a light grey or white, as tools give it to new materials."""
    lightness, a, b = lab_of(np.array([linear_rgb]))[0]
    return bool(np.hypot(a, b) < _MOST_CHROMA and lightness > _LEAST_LIGHTNESS)


def is_tool_name(name: str) -> bool:
    """Whether a name is one that tools give ("Material.001", "lambert1"); a name of a colour is an author's."""
    words: Sequence[str] = [word for word in words_of(name) if word not in _TOOL_NAMES and len(word) > 1]
    return not words or (read_name(" ".join(words)).is_uninformative and not _names_colour(words))


def _names_colour(words: Sequence[str]) -> bool:
    return any(colour_by_name(word) is not None for word in words)
