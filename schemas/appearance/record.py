"""What the record of an asset holds on its appearance: values of each material with their evidence, and colours."""

from __future__ import annotations

from enum import StrEnum
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from schemas.evidence import Evidence

Optics = Literal["opaque", "transmissive", "coated"]


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class MaterialRecord(_Section):
    """One render material as released: the optical behaviour that chose its shaders, and each value with its evidence.

    `values` are by field of `schemas.appearance.material.Material`, of layers as "sheen.color", without those that are
    defaults of a layer that the surface does not have. `shaders` are the surfaces written to the package for it.
    """

    name: str
    optics: Optics
    values: dict[str, Evidence[Any]]
    shaders: tuple[str, ...]


class DegradedReason(StrEnum):
    """Why the appearance of a surface cannot be trusted."""

    NO_MATERIAL = "no material"
    LOST_TEXTURE = "lost texture"
    UNSTATED_COLOUR = "no stated colour"
    DEFAULT_GREY = "an exporter's grey"


class DegradedSurface(_Section):
    """The meshes (ids) of one material whose appearance is missing or degraded; `material` is "" without one."""

    material: str
    meshes: tuple[str, ...]
    reason: DegradedReason


class RecoveryCandidate(_Section):
    """One plausible material that was weighed: `score` is the sum of its `terms` (natural logarithms of odds)."""

    entry: str
    family: str
    score: float
    terms: dict[str, float]


class RecoveredSurface(_Section):
    """What was filled in on a degraded surface, from which entry of the library or generator.

    `material` is the render material as released, `fields` those of its values that were filled in, all others are the
    source's. The confidence of `family` is the probability that the family is right. `candidates` are those that were
    drawn, the chosen one first.
    """

    material: str
    meshes: tuple[str, ...]
    reason: DegradedReason
    family: Evidence[str]
    entry: str
    colour_basis: str
    entry_source: str
    licence: str
    fields: tuple[str, ...]
    candidates: tuple[RecoveryCandidate, ...]


class AppearanceSection(_Section):
    """Render materials as released, and features of the source that no shader of the package expresses.

    `texels_per_m` is the density of base-colour texels on the surface, as a median over the textured area; None without
    textures. `baked_lighting` is the share (0..1) of the variation of the base colour's brightness that light from one
    side explains, where it could be measured. `colours` are basic colour terms with their share of the visible surface,
    by the base colours that materials, textures and vertices state; empty when nothing states one. `degraded` are the
    surfaces that state no appearance that can be trusted, `recovered` what was filled in there, where the user wanted
    that.
    """

    materials: tuple[str, ...]
    colours: dict[str, float] = {}
    textures: tuple[str, ...]
    unmapped: dict[str, dict[str, Any]] = {}
    render_materials: tuple[MaterialRecord, ...] = ()
    texels_per_m: Evidence[float] | None = None
    baked_lighting: Evidence[float] | None = None
    degraded: tuple[DegradedSurface, ...] = Field(default=(), exclude_if=lambda surfaces: not surfaces)
    recovered: tuple[RecoveredSurface, ...] = Field(default=(), exclude_if=lambda surfaces: not surfaces)
