"""What the record of an asset holds on its appearance: values of each material with their evidence, and colours."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

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


class AppearanceSection(_Section):
    """Render materials as released, and features of the source that no shader of the package expresses.

    `texels_per_m` is the density of base-colour texels on the surface, as a median over the textured area; None without
    textures. `baked_lighting` is the share (0..1) of the variation of the base colour's brightness that light from one
    side explains, where it could be measured. `colours` are basic colour terms with their share of the visible surface,
    by the base colours that materials, textures and vertices state; empty when nothing states one.
    """

    materials: tuple[str, ...]
    colours: dict[str, float] = {}
    textures: tuple[str, ...]
    unmapped: dict[str, dict[str, Any]] = {}
    render_materials: tuple[MaterialRecord, ...] = ()
    texels_per_m: Evidence[float] | None = None
    baked_lighting: Evidence[float] | None = None
