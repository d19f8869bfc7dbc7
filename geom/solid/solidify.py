"""The physical solid of an asset from its visual meshes (metres): closed union, shell, voxel proxy or convex hull."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geom.convex.hull import convex_hull
from geom.mass.inertia import combine_volumes
from geom.mesh.edit import merge_surfaces
from geom.mesh.manifold_arrays import signed_volume
from geom.mesh.surface_distance import P95, NearestOnSurface, closest_on_surface, sample_surface, triangle_areas
from geom.mesh.weld import diagonal, weld_points
from geom.repair.boundary_loops import HOLE_SHARE
from geom.solid.closed_bodies import Bodies, Surface, sort_bodies, unite
from geom.solid.nested_shells import nested_volume
from geom.solid.open_parts import additions, volume_of_wall
from geom.solid.voxel_hull import voxel_hull
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh
from schemas.physics import Solid, VolumeProperties

Figures = dict[str, float | int | str]

# The closed bodies represent the asset when they have at least this share of the visible area.
CLOSED_AREA_SHARE = 0.5
LEADING_SHARE = 0.5
SHEET_WALL_PER_DIAGONAL = 0.01
LEAST_SHEET_WALL_M, MOST_SHEET_WALL_M = 0.5e-3, 5e-3
# A flat asset: its hull holds less than this share of the ball with the same diagonal.
FLAT_BOX_SHARE = 1e-3
VOXEL_TOLERANCE_CELLS = 2.0
PROXY_SAMPLES = 2000
# Inner shells with a smaller share of the volume are negligible, filled or empty.
CORE_SHARE = 0.01


def solidify(
    meshes: Sequence[Mesh],
    bodies: Bodies | None = None,
    *,
    rebuild: bool = False,
    wall_m: float | None = None,
    sheets: bool = False,
) -> tuple[Solid, Figures]:
    """The physical surface of `meshes` (metres), and the figures of the method. At least one face must have area.

    `bodies` are those of the meshes where they are known already (`sort_bodies`). With `rebuild` the meshes are too
    damaged for the first two rules, and the third is tried before them. `wall_m` is how thick sheets are, by default
    1 % of the diagonal within 0.5 to 5 mm; with `sheets` all open parts are declared to be sheets, so that neither
    voxels nor hulls replace them.

    Closed parts are solid, open parts are sheets. The first rule that applies:
    1. Closed bodies, holes filled and hidden faces closed (`solid_bodies`, `openings`), carry at least half of the
       area: `closed`, their union (method `union`) with what open parts add to it (`open_parts`): walls grown from
       sheets (method `union_and_walls`), rarely hulls (`union_and_hulls`). Open decoration is left out.
    2. The surface is flat, or at least half of what is open is containers, or one sheet with a mouth wider than a
       quarter of its cross-section: as 1 if there are closed bodies at all, else `shell`, all faces.
    3. Patches with gaps: a voxel proxy and the surface lie within two cells of each other over 95 % of either:
       `closed` (method `voxel`).
    4. At least half of what is open is sheets with mouths: as 2. Else `hull`.
    Figures: `method`, `volume_m3` (shell: area times wall), `area_m2`, `naive_volume_m3` (bodies added up),
    `union_volume_m3`, `components`, `cavities`, `filled_openings`, `open_area_share`.
    """
    bodies = bodies or sort_bodies(meshes)
    points, triangles, _ = merge_surfaces(bodies.tidied)
    points, triangles = weld_points(points, triangles)
    united = unite(bodies.closed) if bodies.closed else None
    naive = sum(signed_volume(*body) for body in bodies.closed)
    total = bodies.closed_area + bodies.open_area
    proxy = _voxel_solid(points, triangles) if rebuild and not sheets else None
    if proxy is not None:
        solid, method = proxy, "voxel"
    elif united is not None and bodies.closed_area >= CLOSED_AREA_SHARE * total:
        solid, method = _with_open_parts(bodies, united, wall_m or assumed_wall_m(diagonal(points)), sheets=sheets)
    else:
        solid, method = _of_open(bodies, points, triangles, sheets=sheets)
        if solid.kind == "shell":
            wall_m = wall_m or assumed_wall_m(diagonal(points))
            solid = replace(solid, wall_thickness_m=wall_m)
            if united is not None:
                solid, method = _with_open_parts(bodies, united, wall_m, sheets=sheets)
    if method.startswith("union") and (core := core_of(meshes, bodies)) is not None:
        solid = replace(solid, core=core if core.volume_m3 >= CORE_SHARE * _volume(solid) else None)
    figures: Figures = {
        "method": method,
        "volume_m3": _volume(solid),
        "area_m2": float(triangle_areas(solid.points[solid.triangles]).sum()),
        "naive_volume_m3": naive,
        "union_volume_m3": signed_volume(*united) if united else 0.0,
        "components": len(bodies.closed) + len(bodies.open_bodies),
        "cavities": bodies.cavities,
        "filled_openings": bodies.filled,
        "open_area_share": bodies.open_area / total if total > 0.0 else 0.0,
    }
    return solid, figures


def core_of(meshes: Sequence[Mesh], bodies: Bodies) -> VolumeProperties | None:
    """The volume of the bodies inside others of the same render material (`nested_volume`).

    A body of another material is a separate part, not a lost cavity.
    """
    by_material: dict[int | None, list[Surface]] = {}
    for mesh, mesh_bodies in zip(meshes, bodies.by_mesh, strict=True):
        by_material.setdefault(mesh.material, []).extend(mesh_bodies)
    cores = [core for group in by_material.values() if (core := nested_volume(group)) is not None]
    return combine_volumes(cores) if cores else None


def _of_open(bodies: Bodies, points: FloatArray, triangles: IntArray, *, sheets: bool) -> tuple[Solid, str]:
    """Rules 2 to 4, for all faces; the thickness of a shell is left to the caller."""
    shell = Solid(points, triangles, kind="shell")
    mouthed = [v for v in bodies.open_bodies if any(o.section_share > HOLE_SHARE for o in v.openings)]
    containers = sum(v.area for v in mouthed if v.kind == "container")
    half = LEADING_SHARE * bodies.open_area
    if sheets or _is_flat(points) or containers >= half > 0.0 or any(v.area >= half > 0.0 for v in mouthed):
        return shell, "shell"
    if (proxy := _voxel_solid(points, triangles)) is not None:
        return proxy, "voxel"
    if sum(v.area for v in mouthed) >= half > 0.0:
        return shell, "shell"
    return Solid(*convex_hull(points), kind="hull"), "hull"


def _voxel_solid(points: FloatArray, triangles: IntArray) -> Solid | None:
    """A voxel proxy of the surface if it lies close to it; walls and sheets inside have distance 0."""
    proxy = voxel_hull(points, triangles)
    if proxy is None:
        return None
    solid = NearestOnSurface(proxy[0], proxy[1])
    surface_samples, _ = sample_surface(points, triangles, PROXY_SAMPLES, 0)
    missing = np.where(
        solid.inside(surface_samples), 0.0, np.linalg.norm(solid(surface_samples)[0] - surface_samples, axis=1)
    )
    proxy_samples, _ = sample_surface(proxy[0], proxy[1], PROXY_SAMPLES, 0)
    added = np.linalg.norm(closest_on_surface(proxy_samples, points, triangles)[0] - proxy_samples, axis=1)
    if max(np.percentile(missing, P95), np.percentile(added, P95)) > VOXEL_TOLERANCE_CELLS * proxy[2]:
        return None
    return Solid(proxy[0], proxy[1], kind="closed")


def _with_open_parts(bodies: Bodies, united: Surface, wall_m: float, *, sheets: bool) -> tuple[Solid, str]:
    """The `united` bodies with what the open parts add; unchanged where these cannot be united."""
    size = diagonal(np.concatenate([mesh.points for mesh in bodies.tidied]))
    added = additions(bodies, united, wall_m, size, hidden=not sheets)
    more = (*added.capped, *added.hulls)
    full = unite([united, *more]) if more else united
    if full is None:
        return Solid(*united, kind="closed"), "union"
    if added.wall is None:
        return Solid(*full, kind="closed"), "union_and_hulls" if added.hulls else "union"
    whole, walls = unite([full, added.wall]), volume_of_wall(added.wall, full)
    if whole is None or walls is None:
        return Solid(*full, kind="closed"), "union"
    return Solid(*whole, kind="closed", wall_thickness_m=wall_m, walls=walls), "union_and_walls"


def assumed_wall_m(size: float) -> float:
    """The thickness assumed of a sheet in an asset with this diagonal."""
    return min(max(SHEET_WALL_PER_DIAGONAL * size, LEAST_SHEET_WALL_M), MOST_SHEET_WALL_M)


def _is_flat(points: FloatArray) -> bool:
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    size = np.ptp(centred @ axes, axis=0)
    return bool(size.prod() < FLAT_BOX_SHARE * diagonal(points) ** 3)


def _volume(solid: Solid) -> float:
    if solid.kind == "shell" and solid.wall_thickness_m is not None:
        return float(triangle_areas(solid.points[solid.triangles]).sum()) * solid.wall_thickness_m
    return signed_volume(solid.points, solid.triangles)
