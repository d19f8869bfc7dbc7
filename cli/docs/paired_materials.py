"""The page `docs/reference/paired-materials.md` from the pairs that ship with Mana."""

from __future__ import annotations

from scenec.source.paired_materials.library import MaterialPair, material_pairs

_INTRODUCTION = """# Paired materials

Each pair is a render material and a physical material, two records with sources of their own
(`scenec/source/paired_materials/*.csv`). A scene program names one by `pair`
([variants](scene-language.md#variants)); at a reset, look and physics change together or not at all. Base colours are
linear. The finish of metals and of polished stone is a choice; friction and restitution are those of the material class
and vary with the counterpart.

| pair | base colour | roughness | metallic | density (kg/m3) | static, dynamic friction | restitution |
|---|---|---|---|---|---|---|
"""


def page() -> str:
    """The page as text."""
    return _INTRODUCTION + "".join(_row(name, pair) for name, pair in material_pairs().items())


def _row(name: str, pair: MaterialPair) -> str:
    look, body = pair.render, pair.physical
    color = ", ".join(f"{channel:.3g}" for channel in look.base_color)
    friction = f"{body.static_friction:g}, {body.dynamic_friction:g}"
    cells = (f"`{name}`", color, f"{look.roughness:g}", f"{look.metallic:g}", f"{body.density_kgm3:g}", friction)
    return f"| {' | '.join(cells)} | {body.restitution:g} |\n"
