"""How thick the walls of an open surface are: as the user says, as a material hints, else a guess by size."""

from __future__ import annotations

from collections.abc import Sequence

from geom.mesh_edit import merge_surfaces
from geom.solid_bodies import tidy
from geom.weld import diagonal, weld_points
from schemas.evidence import Evidence, declared, default, inferred
from schemas.model import Material, Mesh
from schemas.physics import Solid

GUESS_FACTORS = (0.4, 2.5)
# KHR_materials_volume gives the thickness of what light passes through, for looks; often the whole body's.
HINT_FACTORS, HINT_CONFIDENCE = (0.5, 2.0), 0.4
LEAST_M, MOST_SHARE = 1e-4, 0.05  # A hint outside these is no wall: metres, share of the diagonal.


def with_wall(
    solid: Solid,
    method: str,
    meshes: Sequence[Mesh],
    *,
    stated_m: float | None,
    materials: Sequence[Material],
    meters_per_unit: float,
) -> tuple[Solid, Evidence[float] | None]:
    """`solid` with its wall thickness in metres and where that comes from; None for a solid that is no sheet.

    A thickness that the user states makes a shell of every surface that is not closed by itself: of sheets, and of what
    a voxel proxy (`method`) or hull would stand in for. Without it only sheets are shells: of the thickness that a
    render material hints, or of the one assumed in `geom.solid`.
    """
    if stated_m is not None and (solid.kind != "closed" or method == "voxel"):
        points, triangles, _ = merge_surfaces([tidy(mesh) for mesh in meshes])
        points, triangles = weld_points(points, triangles)
        return Solid(points, triangles, "shell", stated_m), declared(stated_m, "--shell-thickness")
    if solid.kind != "shell" or solid.wall_thickness_m is None:
        return solid, None
    hint_m = _hinted(materials, meters_per_unit)
    if LEAST_M <= hint_m <= MOST_SHARE * diagonal(solid.points):
        bounds = (HINT_FACTORS[0] * hint_m, HINT_FACTORS[1] * hint_m)
        wall = inferred(hint_m, "KHR_materials_volume thicknessFactor", HINT_CONFIDENCE, bounds=bounds)
        return Solid(solid.points, solid.triangles, "shell", hint_m), wall
    guess = solid.wall_thickness_m
    bounds = (GUESS_FACTORS[0] * guess, GUESS_FACTORS[1] * guess)
    return solid, default(guess, "1 % of the diagonal, within 0.5 and 5 mm", bounds=bounds)


def _hinted(materials: Sequence[Material], meters_per_unit: float) -> float:
    """The largest thickness that a material states (m), 0 when none does."""
    volumes = [material.unmapped.get("KHR_materials_volume", {}) for material in materials]
    stated = [volume.get("thicknessFactor") for volume in volumes]
    return max((value * meters_per_unit for value in stated if isinstance(value, int | float)), default=0.0)
