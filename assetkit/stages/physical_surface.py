"""The physical surface of mended meshes, and how far it lies from the visible one; part of stage 2, canonicalize."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.options import Options
from assetkit.self_union import self_union
from assetkit.stages.distortion import Distortion
from assetkit.stages.repair_geometry import RepairResult
from assetkit.stages.triangle_budget import Budgeted
from assetkit.wall import with_wall
from geom.resolve_bodies import resolve_bodies
from geom.solid import solidify
from geom.solid_bodies import sort_bodies
from geom.solid_distance import SolidDistance, solid_distance
from geom.surface_distance import triangle_areas
from geom.weld import diagonal
from schemas.evidence import Evidence
from schemas.model import FloatArray, Material, Mesh
from schemas.outcome import Repair
from schemas.physics import Solid

# Repairs that leave the visible surface alone and change the physical one instead.
PHYSICAL_REPAIRS = ("asset/overlapping-bodies", "asset/self-intersection", "asset/dirty-mesh")


@dataclass(frozen=True)
class PhysicalSurface:
    """The solid in the asset frame (metres), how it came about, and its wall where it is a sheet.

    `repairs` are those of the mended meshes, with the distance of the solid where they changed only that;
    `distortions` holds what rebuilding it from scratch may have cost.
    """

    solid: Solid
    method: str
    volume_m3: float
    area_m2: float
    wall: Evidence[float] | None
    distance: SolidDistance
    repairs: tuple[Repair, ...]
    distortions: tuple[Distortion, ...]


def physical_surface(
    mended: RepairResult,
    light: Budgeted,
    p_origin: FloatArray,
    *,
    options: Options,
    materials: Sequence[Material],
    meters_per_unit: float,
) -> PhysicalSurface:
    """The physical surface of the meshes in `light`, whose asset frame has its origin at `p_origin` (3,)."""
    bodies = resolve_bodies(sort_bodies(light.meshes), self_union)[0] if light.repairs else mended.bodies
    rebuild = any(r.code == "asset/dirty-mesh" for r in mended.repairs)
    made, figures = solidify(light.meshes, bodies, rebuild=rebuild)
    solid, wall = with_wall(
        _moved(made, -p_origin),
        str(figures["method"]),
        homed := at_origin(light.meshes, p_origin),
        stated_m=options.shell_thickness_m,
        materials=materials,
        meters_per_unit=meters_per_unit,
    )
    distance, size = solid_distance(homed, solid), diagonal(np.concatenate([m.points for m in homed]))
    area = float(triangle_areas(solid.points[solid.triangles]).sum())
    furthest = max(distance.added, distance.missing, key=lambda way: way.attained)
    lost = Distortion("mesh_repair", furthest.attained, furthest.attained, size, None, furthest.at + p_origin)
    return PhysicalSurface(
        solid,
        method=str(figures["method"]) if wall is None else f"{wall.source}_shell",
        volume_m3=float(figures["volume_m3"]) if wall is None else area * wall.value,
        area_m2=area,
        wall=wall,
        distance=distance,
        repairs=tuple(_with_distance(r, distance, size) for r in mended.repairs),
        distortions=(lost,) if rebuild else (),
    )


def _moved(solid: Solid, shift: FloatArray) -> Solid:
    core = solid.core
    if core is not None:
        core = replace(core, centre_of_mass_m=core.centre_of_mass_m + shift)
    return replace(solid, points=solid.points + shift, core=core)


def at_origin(meshes: Sequence[Mesh], p_origin: FloatArray) -> tuple[Mesh, ...]:
    """The meshes moved so that `p_origin` (3,) becomes the origin."""
    return tuple(replace(m, points=m.points - p_origin) for m in meshes)


def _with_distance(repair: Repair, distance: SolidDistance, size: float) -> Repair:
    if repair.code not in PHYSICAL_REPAIRS:
        return repair
    now = {"solid_distance_m": distance.attained, "solid_distance_share": distance.attained / size}
    return repair.model_copy(
        update={"before": {**repair.before, **dict.fromkeys(now, 0.0)}, "after": {**repair.after, **now}}
    )
