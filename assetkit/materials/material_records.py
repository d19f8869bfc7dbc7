"""What the record holds on each render material: optics, every value with its evidence, and the shaders written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from schemas.appearance.material import Material, TextureUse
from schemas.appearance.optics import optics_of, stated_values
from schemas.appearance.record import MaterialRecord
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.evidence import Evidence, default
from schemas.model import Model
from usdio.write.materials.mesh_materials import materials_per_mesh
from usdio.write.materials.outputs import FOR_RASTERISERS, lost_by_shader


def material_records(model: Model) -> tuple[tuple[MaterialRecord, ...], tuple[Diagnostic, ...]]:
    """A record of each material of `model`, and a finding for each whose values some shader does not show.

    A material that no mesh uses has no shaders. `asset/shader-lacks-layer` where another shader of the material shows
    the value, `asset/material-extension-fallback` where none does.
    """
    images = {texture.name: texture for texture in model.textures}
    lost: dict[str, dict[str, frozenset[str]]] = {}
    for mesh_material in {of_mesh.prim_name: of_mesh for of_mesh in materials_per_mesh(model)}.values():
        of_material = lost.setdefault(mesh_material.material.name, {})
        for shader, fields in lost_by_shader(mesh_material, images).items():
            of_material[shader] = of_material.get(shader, frozenset[str]()) | fields
    records = tuple(_record(material, tuple(lost.get(material.name, ()))) for material in model.materials)
    return records, tuple(note for name, by_shader in lost.items() for note in _dropped(name, by_shader))


def _record(material: Material, shaders: Sequence[str]) -> MaterialRecord:
    values = {field: _evidence(material, field, value) for field, value in stated_values(material).items()}
    return MaterialRecord(name=material.name, optics=optics_of(material), values=values, shaders=tuple(shaders))


def _evidence(material: Material, field: str, value: Any) -> Evidence[Any]:
    """The evidence of one value: its origin, or a default of confidence 0."""
    plain = _plain(value)
    origin = material.origins.get(field)
    if origin is None:
        return default(plain, "no evidence: the default of the material model")
    return Evidence(value=plain, source=origin.source, method=origin.method, confidence=origin.confidence)


def _plain(value: Any) -> Any:
    """The value as JSON has it: texture uses by field, colours as lists."""
    if isinstance(value, TextureUse):
        return {field: _plain(of) for field, of in asdict(value).items()}
    return [*value] if isinstance(value, tuple) else value


def _dropped(name: str, by_shader: dict[str, frozenset[str]]) -> list[Diagnostic]:
    """At most one finding of each kind on the material called `name`."""
    nowhere = frozenset.intersection(*by_shader.values())
    notes: list[Diagnostic] = []
    if nowhere:
        headline = f"no shader of material '{name}' shows {', '.join(sorted(nowhere))}"
        where, value = Location(prim=name), ", ".join(sorted(nowhere))
        notes.append(finding("asset/material-extension-fallback", headline, where=where, value=value))
    stated = nowhere | FOR_RASTERISERS
    partly = {shader: sorted(fields - stated) for shader, fields in by_shader.items() if fields - stated}
    if partly:
        headline = f"material '{name}' is shown in part by {' and '.join(partly)}"
        value = "; ".join(f"{shader}: {', '.join(fields)}" for shader, fields in partly.items())
        notes.append(finding("asset/shader-lacks-layer", headline, where=Location(prim=name), value=value))
    return notes
