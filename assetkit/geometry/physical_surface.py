"""The physical surface (solid, metres) of mended meshes, and its distance from the visible one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.colliders.self_union import self_union
from assetkit.geometry.distortion import Distortion
from assetkit.geometry.repair import RepairResult
from assetkit.geometry.triangle_budget import BudgetResult
from assetkit.mass.wall_thickness import wall_evidence
from assetkit.options import Options
from geom.mesh.hausdorff import DistanceBounds
from geom.mesh.surface_distance import closest_on_surface, triangle_areas
from geom.mesh.weld import diagonal
from geom.solid.closed_bodies import sort_bodies
from geom.solid.self_intersections import resolve_bodies
from geom.solid.solid_distance import SolidDistance, solid_distance
from geom.solid.solidify import solidify
from schemas.appearance.material import Material
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import Mesh
from schemas.outcome import Repair
from schemas.physics import Solid

# Repairs that leave the visible surface alone and change the physical one instead.
PHYSICAL_REPAIRS = ("asset/overlapping-bodies", "asset/self-intersection", "asset/dirty-mesh")
# Methods whose solid does not follow the surface.
FALLBACK_METHODS = ("voxel", "union_and_hulls", "hull")


@dataclass(frozen=True)
class PhysicalSurface:
    """The solid in the asset frame (metres), how it came about, and its wall where sheets are in it.

    `repairs` are those of the mended meshes, with the distance of the solid where they changed only that;
    `distortions` holds how far it departs from what is seen.
    """

    solid: Solid
    method: str
    volume_m3: float
    area_m2: float
    wall: Evidence[float] | None
    distance: SolidDistance
    repairs: tuple[Repair, ...]
    distortions: tuple[Distortion, ...]
    diagnostics: tuple[Diagnostic, ...]


def physical_surface(
    mended: RepairResult,
    light: BudgetResult,
    p_origin: FloatArray,
    *,
    options: Options,
    materials: Sequence[Material],
    meters_per_unit: float,
) -> PhysicalSurface:
    """The physical surface of the meshes in `light`, whose asset frame has its origin at `p_origin` (3,)."""
    bodies = resolve_bodies(sort_bodies(light.meshes), self_union)[0] if light.repairs else mended.bodies
    rebuild = any(r.code == "asset/dirty-mesh" for r in mended.repairs)
    homed = at_origin(light.meshes, p_origin)
    size = diagonal(np.concatenate([m.points for m in homed]))
    wall = wall_evidence(size, stated_m=options.shell_thickness_m, materials=materials, meters_per_unit=meters_per_unit)
    solid_in_scene, figures = solidify(
        light.meshes, bodies, rebuild=rebuild, wall_m=wall.value, sheets=options.shell_thickness_m is not None
    )
    solid, method, volume = _moved(solid_in_scene, -p_origin), str(figures["method"]), float(figures["volume_m3"])
    distance = solid_distance(homed, solid)
    departed = _departure(distance, method)
    method_by_wall = {"shell": f"{wall.source}_shell", "union_and_walls": f"union_and_{wall.source}_walls"}
    lost = Distortion(
        "mesh_repair" if rebuild else method,
        departed.attained,
        departed.attained,
        size,
        _nearest_mesh(homed, departed.at),
        departed.at + p_origin,
    )
    return PhysicalSurface(
        solid,
        method=method_by_wall.get(method, method),
        volume_m3=volume,
        area_m2=float(triangle_areas(solid.points[solid.triangles]).sum()),
        wall=wall if solid.wall_thickness_m is not None else None,
        distance=distance,
        repairs=tuple(_with_distance(r, distance, size) for r in mended.repairs),
        distortions=(lost,),
        diagnostics=_sheet_findings(solid, wall, volume),
    )


def _departure(distance: SolidDistance, method: str) -> DistanceBounds:
    """The distance that needs review when large: of visible parts outside the solid; and, for voxels or hulls, of
    matter that nothing shows. Caps and walls add matter too, but are reported on their own.
    """
    if method in FALLBACK_METHODS:
        return max(distance.added, distance.missing, key=lambda way: way.attained)
    return distance.missing


def _nearest_mesh(meshes: Sequence[Mesh], place: FloatArray) -> str | None:
    """The name of the mesh nearest to `place` (3,); None where that is nowhere."""
    if not np.isfinite(place).all():
        return None
    solid = [m for m in meshes if triangle_areas(m.points[m.triangles]).any()]
    away = [np.linalg.norm(closest_on_surface(place[None], m.points, m.triangles)[0] - place) for m in solid]
    return solid[int(np.argmin(away))].name


def _sheet_findings(solid: Solid, wall: Evidence[float], volume_m3: float) -> tuple[Diagnostic, ...]:
    """The finding where open sheets are beside closed bodies."""
    if solid.walls is None:
        return ()
    share = solid.walls.volume_m3 / volume_m3
    headline = (
        f"open sheets beside closed bodies count as walls of {1e3 * wall.value:.3g} mm ({wall.source}), "
        f"{share:.0%} of the volume"
    )
    return (finding("asset/open-shell", headline, value=wall.value, unit="m"),)


def _moved(solid: Solid, shift: FloatArray) -> Solid:
    core, walls = (
        None if inner is None else replace(inner, centre_m=inner.centre_m + shift)
        for inner in (solid.core, solid.walls)
    )
    return replace(solid, points=solid.points + shift, core=core, walls=walls)


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
