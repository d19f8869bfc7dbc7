"""Reads the pairs that ship with Mana, and fills materials of scene programs from them.

A render template and a physical template are two records with sources of their own; a pair names one of each.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from schemas.diagnostics import Diagnostic, finding
from schemas.scene.program import PairedMaterial, SceneProgram
from source.hint import did_you_mean
from source.tree import Spans

_FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class RenderTemplate:
    """What a surface looks like: linear base colour, roughness and metalness of metallic-roughness PBR."""

    base_color: tuple[float, float, float]
    roughness: float
    metallic: float
    source: str


@dataclass(frozen=True)
class PhysicalTemplate:
    """What a body is made of: density, Coulomb friction and restitution against any counterpart.

    `material_class` is the class of the material table whose contact values these are.
    """

    material_class: str
    density_kgm3: float
    static_friction: float
    dynamic_friction: float
    restitution: float
    source: str


@dataclass(frozen=True)
class MaterialPair:
    """The two records of one material."""

    render: RenderTemplate
    physical: PhysicalTemplate


@cache
def material_pairs() -> Mapping[str, MaterialPair]:
    """All pairs by name, in the order of `pairs.csv`."""
    renders = {row["name"]: _render(row) for row in _rows("render_templates.csv")}
    physicals = {row["name"]: _physical(row) for row in _rows("physical_templates.csv")}
    return {row["name"]: MaterialPair(renders[row["render"]], physicals[row["physical"]]) for row in _rows("pairs.csv")}


def check_pairs(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    """A `scene/unknown-name` for each material whose `pair` is none of the library."""
    for number, material in enumerate(program.variants.materials):
        if material.pair is not None and material.pair not in material_pairs():
            hint = did_you_mean(material.pair, material_pairs())
            where = spans.place(("variants", "materials", number, "pair"))
            yield finding("scene/unknown-name", f"there is no pair of materials `{material.pair}`{hint}", where=where)


def with_pairs(program: SceneProgram) -> SceneProgram:
    """The program whose materials have all values of their pair; what the program states itself stays."""
    if all(material.pair is None for material in program.variants.materials):
        return program
    materials = tuple(_filled(material) for material in program.variants.materials)
    return program.model_copy(update={"variants": program.variants.model_copy(update={"materials": materials})})


def _filled(material: PairedMaterial) -> PairedMaterial:
    if material.pair is None:
        return material
    pair = material_pairs()[material.pair]
    values = {
        "base_color": pair.render.base_color,
        "roughness": pair.render.roughness,
        "metallic": pair.render.metallic,
        "density_kgm3": pair.physical.density_kgm3,
        "static_friction": pair.physical.static_friction,
        "dynamic_friction": pair.physical.dynamic_friction,
        "restitution": pair.physical.restitution,
    }
    absent = {name: value for name, value in values.items() if getattr(material, name) is None}
    return material.model_copy(update=absent)


def _rows(name: str) -> list[dict[str, str]]:
    with (_FOLDER / name).open(newline="") as file:
        return list(csv.DictReader(file))


def _render(row: dict[str, str]) -> RenderTemplate:
    color = float(row["red"]), float(row["green"]), float(row["blue"])
    return RenderTemplate(color, float(row["roughness"]), float(row["metallic"]), row["source"])


def _physical(row: dict[str, str]) -> PhysicalTemplate:
    return PhysicalTemplate(
        row["material_class"],
        float(row["density_kgm3"]),
        float(row["static_friction"]),
        float(row["dynamic_friction"]),
        float(row["restitution"]),
        row["source"],
    )
