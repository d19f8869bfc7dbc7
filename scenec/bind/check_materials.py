"""Checks that acceptance exercised the friction and mass that paired materials give to objects."""

from __future__ import annotations

from collections.abc import Iterator

from scenec.bind.asset_library import AssetLibrary, Geometry
from scenec.ir.single_assets import single_assets
from scenec.source.listing import written_assets
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.exercised import ExercisedRange
from schemas.scene.geometry import BACKGROUND
from schemas.scene.program import PairedMaterial, SceneProgram
from source.tree import Spans


def check_materials(program: SceneProgram, library: AssetLibrary, spans: Spans) -> tuple[Diagnostic, ...]:
    """A `scene/beyond-exercised` for each material, asset and quantity beyond what acceptance exercised."""
    diagnostics: dict[tuple[int, str, str], Diagnostic] = {}
    for number, material in enumerate(program.variants.materials):
        where = spans.place(("variants", "materials", number))
        for geometry in _dressed(program, material, library):
            for limit, value in _values(geometry, material):
                if not limit.holds(value):
                    key = (number, geometry.asset_id, limit.quantity)
                    diagnostics.setdefault(
                        key, _beyond(geometry, material, limit, value).model_copy(update={"where": where})
                    )
    return tuple(diagnostics.values())


def _dressed(program: SceneProgram, material: PairedMaterial, library: AssetLibrary) -> Iterator[Geometry]:
    """The geometries of every asset that may wear the material; `check_assets` finds what is wrong with them."""
    for written in written_assets(program):
        match written.path:
            case ("objects", int(number), *_):
                name = program.objects[number].id
            case ("variants", "assets", _, "objects", name):
                pass
            case _:
                name = BACKGROUND
        if name not in material.objects:
            continue
        for single in single_assets(written.asset):
            try:
                yield library.geometry(single, written.scale)
            except InvalidInput:
                continue


def _values(geometry: Geometry, material: PairedMaterial) -> Iterator[tuple[ExercisedRange, float]]:
    """What the material sets, beside the range that was exercised."""
    tried = geometry.exercised
    if tried is None:
        return
    friction = material.dynamic_friction if material.dynamic_friction is not None else tried.friction.value
    if material.static_friction is not None:
        friction = min(friction, material.static_friction)  # as `runtime_plan.materials.with_material`
    yield tried.friction, friction
    if material.density_kgm3 is not None and geometry.density_kgm3:
        yield tried.mass_kg, tried.mass_kg.value * material.density_kgm3 / geometry.density_kgm3


def _beyond(geometry: Geometry, material: PairedMaterial, limit: ExercisedRange, value: float) -> Diagnostic:
    what, unit = ("friction", "") if limit.quantity == "friction" else ("mass", "kg")
    by = f"; beyond it {', '.join(limit.limited_by)} failed" if limit.limited_by else ""
    headline = f"`{material.id}` gives `{geometry.asset_id}` a {what} that acceptance did not exercise{by}"
    bound = f"{limit.low:.3g} to {limit.high:.3g}"
    return finding("scene/beyond-exercised", headline, value=round(value, 4), bound=bound, unit=unit)
