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
    """Render materials as authored, and features of the source that UsdPreviewSurface cannot express.

    `colours` are basic colour terms with their share of the visible surface, by the base colours that materials,
    textures and vertices state; empty when nothing states one.
    """

    materials: tuple[str, ...]
    colours: dict[str, float] = {}
    textures: tuple[str, ...]
    unmapped: dict[str, dict[str, Any]] = {}
    render_materials: tuple[MaterialRecord, ...] = ()
