"""Density (kg/m3) of a compact body of unknown material, hollows included, from its size and its appearance."""

from __future__ import annotations

import math
from collections.abc import Sequence

from assetkit.mass.bounds import MAX_SPAN, mean_thickness
from assetkit.mass.excluded_materials import excluded_materials
from assetkit.readers.by_format import CAD_FORMATS
from geom.convex.hull import convex_hull
from geom.mesh.surface_distance import triangle_areas
from schemas.appearance.material import Material
from schemas.evidence import Evidence, default
from schemas.model import Mesh
from schemas.physics import Solid

# Mass over the volume inside the outer surface. Of household things the size of a cube of 10 cm: 150 to 1100 kg/m3,
# about 500 in the middle (YCB set, Calli et al. 2015). Walls thicken with the root of size (0.5 mm of plastic at 1 cm,
# 1.5 mm at 10 cm, 0.6 mm of steel sheet at 1 m), so density falls with it: a bolt is solid, a washing machine is not.
USUAL_KGM3, USUAL_SIZE_M = 500.0, 0.1
# A part from CAD is drawn with its walls, and what looks like bare metal is of metal: solid steel up to 10 cm.
DENSE_FACTOR = 3.0
DENSEST_KGM3 = 8100.0  # Stainless steel, as in `materials.csv`.
METALLIC, METALLIC_SHARE = 0.5, 0.5


def unknown_density(solid: Solid, dense_reason: str = "") -> Evidence[float] | None:
    """Density of a thick body of which nothing is known (kg/m3): the middle of a window of 30x that goes with its size.

    Size is the edge of the cube with the same ratio of volume to surface. `dense_reason` is the reason why the body is
    likely solid (`dense_appearance`), "" without one. The method names the materials that the bounds exclude. None when
    the body has no volume.
    """
    size_m = _size(solid)
    if not size_m > 0.0:
        return None
    half = math.sqrt(MAX_SPAN)
    usual = USUAL_KGM3 * (DENSE_FACTOR if dense_reason else 1.0) * math.sqrt(USUAL_SIZE_M / size_m)
    value = min(usual, DENSEST_KGM3 / half)
    low, high = value / half, value * half
    reason = f"{dense_reason}, " if dense_reason else ""
    method = f"things {100.0 * size_m:.3g} cm in size, {reason}{low:.0f} to {high:.0f} kg/m3"
    return default(value, method + excluded_materials(low, high), bounds=(low, high))


def dense_appearance(format_: str, meshes: Sequence[Mesh], materials: Sequence[Material]) -> str:
    """Why the body is likely solid or of metal, "" when nothing says so: a format of CAD parts, or bare metal.

    Metal is a constant metallic factor of at least 0.5 over half of the surface. A glTF material that gives neither
    factor has metallic and roughness 1 by default, so those two together say nothing.
    """
    if format_ in CAD_FORMATS:
        return f"part in {format_.upper()}"
    areas = [float(triangle_areas(mesh.points[mesh.triangles]).sum()) for mesh in meshes]
    metal = sum(
        area
        for area, mesh in zip(areas, meshes, strict=True)
        if mesh.material is not None and _is_metal(materials[mesh.material])
    )
    return "metallic surface" if metal > 0.0 and metal >= METALLIC_SHARE * sum(areas) else ""


def _is_metal(material: Material) -> bool:
    silent = material.metallic == material.roughness == 1.0
    return material.metallic >= METALLIC and material.metallic_texture is None and not silent


def _size(solid: Solid) -> float:
    if solid.kind != "hull":
        return 3.0 * mean_thickness(solid)
    try:
        return 3.0 * mean_thickness(Solid(*convex_hull(solid.points), "closed"))
    except ValueError:  # Flat.
        return 0.0
