"""Geoms of an MJCF model as shapes of their body: kinds, sizes, `fromto`, colours, what counts for inertia.

mujoco.readthedocs.io/en/stable/XMLreference.html#body-geom.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from formats.attributes import Attributes, choice, number, numbers
from formats.mjcf.assets import Assets
from formats.mjcf.orientations import z_along
from formats.mjcf.settings import CompilerSettings
from formats.xml_elements import refuse
from geom.pose import pose
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, Severity, finding
from schemas.robot_description import (
    DescribedMaterial,
    DescribedShape,
    DescribedShapeKind,
    ShapeFriction,
    SourceLine,
)

WATER_KGM3 = 1000.0  # MuJoCo's default density of a geom
_KINDS: Mapping[str, DescribedShapeKind] = {
    "sphere": "sphere",
    "plane": "plane",
    "capsule": "capsule",
    "ellipsoid": "ellipsoid",
    "cylinder": "cylinder",
    "box": "box",
    "mesh": "mesh",
    "hfield": "heightfield",
    "sdf": "unknown",
}
_SIZES = {"plane": 2, "sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
_WEIGHTLESS = ("plane", "heightfield", "unknown")


def geom_shape(
    a: dict[str, str], source: SourceLine, body: str, X_BF: FloatArray, settings: CompilerSettings, assets: Assets
) -> DescribedShape:
    """The shape of a geom with attributes `a` (defaults merged) in a frame at X_BF of its body.

    A shape that cannot be used keeps its `problem`. Raises InvalidInput for wrong numbers and dangling references.
    """
    kind = _KINDS[choice(a, "type", tuple(_KINDS), "sphere", source)]
    place = f"geom '{a.get('name', '')}' of body '{body}'"
    mesh = assets.meshes.get(a.get("mesh", ""))
    if mesh is None and (a.get("mesh") or kind == "mesh"):
        name = a.get("mesh", "")
        headline = f"{place} names the unknown mesh '{name}'" if name else f"{place} is a mesh and names none"
        refuse("robot/unknown-reference", headline, source, value=name)
    stated_size = numbers(a, "size", None, (), source)
    between = "fromto" in a and kind in ("capsule", "cylinder", "box", "ellipsoid")
    X_FG, size = (
        _between(a, stated_size, kind, place, source)
        if between
        else (settings.orientations.pose(a, source), stated_size)
    )
    if mesh is not None and kind != "mesh":
        kind = "fitted"
    size_m, problem = _size(kind, size, place, source)
    first, last = settings.inertia_groups
    group = int(number(a, "group", 0.0, source))
    weighs = first <= group <= last and kind not in _WEIGHTLESS
    weighs = weighs and a.get("mass", "1").strip("0. ") != ""  # A geom of no mass does not count.
    mass_kg = number(a, "mass", None, source) if weighs and "mass" in a else None
    friction = numbers(a, "friction", None, (), source)
    return DescribedShape(
        name=a.get("name", ""),
        kind=kind,
        size_m=size_m,
        X_LS=X_BF @ X_FG,
        collides=any(number(a, key, 1.0, source) != 0.0 for key in ("contype", "conaffinity")),
        drawn=True,
        mesh=mesh,
        material=_material(a, source, place, assets),
        friction=ShapeFriction(friction[0], friction[0]) if friction else None,
        mass_kg=mass_kg,
        density_kgm3=number(a, "density", WATER_KGM3, source) if weighs and mass_kg is None else None,
        group=group,
        problem=problem,
        source=source,
    )


def _between(
    a: Attributes, size: tuple[float, ...], kind: DescribedShapeKind, place: str, source: SourceLine
) -> tuple[FloatArray, tuple[float, ...]]:
    """Pose and sizes of a geom between two points; its z axis runs from the second to the first, as in MuJoCo."""
    ends = np.array(numbers(a, "fromto", 6, None, source)).reshape(2, 3)
    if not size:
        refuse("robot/invalid-size", f"{place} has no size", source)
    half = float(np.linalg.norm(ends[1] - ends[0])) / 2.0
    X_FG = pose(z_along(ends[0] - ends[1], source), ends.mean(axis=0))
    return X_FG, (size[0], half) if kind in ("capsule", "cylinder") else (size[0], size[0], half)


def _size(
    kind: DescribedShapeKind, size: tuple[float, ...], place: str, source: SourceLine
) -> tuple[tuple[float, ...], Diagnostic | None]:
    """Sizes as `DescribedShape` has them, from MuJoCo's half lengths; or why there are none."""
    needed = _SIZES.get(kind, 0)
    if len(size) < needed or (kind != "plane" and min(size[:needed], default=1.0) <= 0.0):
        headline = f"{place} has size {size}"
        return (), finding("robot/invalid-size", headline, where=source.location, value=str(size), bound=0.0)
    if kind in ("fitted", "heightfield", "unknown"):
        what = "fitted to a mesh" if kind == "fitted" else f"of a kind ({kind})"
        headline = f"{place} is {what}, which is not read"
        return (), finding("robot/unsupported-shape", headline, where=source.location, value=kind)
    if kind == "mesh":
        return (), None
    if kind == "sphere":
        return (size[0],), None
    if kind in ("capsule", "cylinder"):
        return (size[0], 2.0 * size[1]), None
    if kind == "ellipsoid":
        return size[:3], None
    return tuple(2.0 * s for s in size[:needed]), None


def _material(a: Attributes, source: SourceLine, place: str, assets: Assets) -> DescribedMaterial | None:
    """The material of the geom; a colour of its own replaces the material's."""
    name = a.get("material", "")
    if name and name not in assets.materials:
        headline, severity = f"{place} names the unknown material '{name}'", Severity.WARNING
        assets.notes.append(
            finding("robot/unknown-reference", headline, where=source.location, value=name, severity=severity)
        )
    material = assets.materials.get(name)
    if "rgba" not in a:
        return material
    red, green, blue, opacity = numbers(a, "rgba", 4, None, source)
    return replace(material or DescribedMaterial(name), rgba=(red, green, blue, opacity), source=source)
