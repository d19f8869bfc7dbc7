"""From visual meshes to the physical surface that mass and collision are based on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import trimesh

from geom.enclosed import enclosed_matter
from geom.inertia import combine
from geom.mesh_edit import merge_surfaces
from geom.openings import HOLE_SHARE
from geom.solid_bodies import Bodies, Surface, signed_volume, sort_bodies, unite
from geom.solid_voxel import voxel_hull
from geom.surface_distance import P95, NearestOnSurface, closest_on_surface, sample_surface, triangle_areas
from geom.weld import diagonal, weld_points
from schemas.model import FloatArray, IntArray, Mesh
from schemas.physics import MassProperties, Solid

Figures = dict[str, float | int | str]

# The closed bodies stand for the asset when they carry at least this share of the visible area.
CLOSED_AREA_SHARE = 0.5
LEADING_SHARE = 0.5
WALL_PER_DIAGONAL = 0.01
LEAST_WALL_M, MOST_WALL_M = 0.5e-3, 5e-3
# A flat asset: its hull holds less than this share of the ball with the same diagonal.
FLAT_SHARE = 1e-3
VOXEL_TOLERANCE_CELLS = 2.0
DISTANCE_SAMPLES = 2000
# Inner shells that hold less of the solid change nothing, filled or empty.
CORE_SHARE = 0.01
PROTRUDING = 0.05  # Acceptance refuses colliders whose box misses the visible one by more.


def solidify(meshes: Sequence[Mesh], bodies: Bodies | None = None, *, rebuild: bool = False) -> tuple[Solid, Figures]:
    """The physical surface of `meshes` (metres), and how it came about. At least one face must have area.

    `bodies` are those of the meshes where they are known already (`sort_bodies`). With `rebuild` the meshes are too
    damaged for the first two rules, and the third is tried before them.

    First rule that applies:
    1. Closed bodies, holes filled and hidden faces closed (`solid_bodies`, `openings`), carry at least half of the
       area: `closed`, their union (method `union`; open decoration is left out). Open parts that reach beyond the
       bodies by more than 5 % of the diagonal are no decoration: their hulls, cards as slabs, join the union (method
       `union_and_hulls`).
    2. The surface is flat, or at least half of what is open is containers, or one sheet with a mouth wider than a
       quarter of its cross-section: `shell`, all faces, with an assumed wall of 1 % of the diagonal within 0.5 to 5 mm.
    3. Patches with gaps: a voxel proxy and the surface lie within two cells of each other over 95 % of either:
       `closed` (method `voxel`).
    4. At least half of what is open is sheets with mouths: `shell`. Else `hull`.
    Figures: `method`, `volume_m3` (shell: area times wall), `area_m2`, `naive_volume_m3` (bodies added up),
    `union_volume_m3`, `components`, `cavities`, `filled_openings`, `open_area_share`.
    """
    bodies = bodies or sort_bodies(meshes)
    points, triangles, _ = merge_surfaces(bodies.tidied)
    points, triangles = weld_points(points, triangles)
    united = unite(bodies.closed) if bodies.closed else None
    naive = sum(signed_volume(*body) for body in bodies.closed)
    total = bodies.closed_area + bodies.open_area
    proxy = _voxel_solid(points, triangles) if rebuild else None
    solid, method = (proxy, "voxel") if proxy else _choose(bodies, united, points, triangles, total)
    if method == "union" and (core := core_of(meshes, bodies)) is not None:
        solid = replace(solid, core=core if core.mass_kg >= CORE_SHARE * _volume(solid) else None)
    figures: Figures = {
        "method": method,
        "volume_m3": _volume(solid),
        "area_m2": float(triangle_areas(solid.points[solid.triangles]).sum()),
        "naive_volume_m3": naive,
        "union_volume_m3": signed_volume(*united) if united else 0.0,
        "components": len(bodies.closed) + len(bodies.verdicts),
        "cavities": bodies.cavities,
        "filled_openings": bodies.filled,
        "open_area_share": bodies.open_area / total if total > 0.0 else 0.0,
    }
    return solid, figures


def core_of(meshes: Sequence[Mesh], bodies: Bodies) -> MassProperties | None:
    """What the bodies of `meshes` hold that lie inside others of the same render material (`enclosed_matter`).

    A part of another material is a part, no lost cavity.
    """
    by_look: dict[int | None, list[Surface]] = {}
    for mesh, own in zip(meshes, bodies.by_mesh, strict=True):
        by_look.setdefault(mesh.material, []).extend(own)
    cores = [core for group in by_look.values() if (core := enclosed_matter(group)) is not None]
    return combine(cores) if cores else None


def _choose(
    bodies: Bodies, united: tuple[FloatArray, IntArray] | None, points: FloatArray, triangles: IntArray, total: float
) -> tuple[Solid, str]:
    if united is not None and bodies.closed_area >= CLOSED_AREA_SHARE * total:
        return _with_protruding(bodies, united, diagonal(points))
    wall = _wall(diagonal(points))
    shell = Solid(points, triangles, kind="shell", wall_thickness_m=wall)
    mouthed = [v for v in bodies.verdicts if any(o.section_share > HOLE_SHARE for o in v.openings)]
    containers = sum(v.area for v in mouthed if v.kind == "container")
    half = LEADING_SHARE * bodies.open_area
    if _is_flat(points) or containers >= half > 0.0 or any(v.area >= half > 0.0 for v in mouthed):
        return shell, "shell"
    if (proxy := _voxel_solid(points, triangles)) is not None:
        return proxy, "voxel"
    if sum(v.area for v in mouthed) >= half > 0.0:
        return shell, "shell"
    hull = trimesh.PointCloud(points).convex_hull
    return Solid(np.array(hull.vertices), np.array(hull.faces, dtype=np.int32), kind="hull"), "hull"


def _voxel_solid(points: FloatArray, triangles: IntArray) -> Solid | None:
    """A voxel proxy of the surface if it lies close to it; walls and sheets inside are at no distance."""
    proxy = voxel_hull(points, triangles)
    if proxy is None:
        return None
    solid = NearestOnSurface(proxy[0], proxy[1])
    seen, _ = sample_surface(points, triangles, DISTANCE_SAMPLES, 0)
    missing = np.where(solid.inside(seen), 0.0, np.linalg.norm(solid(seen)[0] - seen, axis=1))
    made, _ = sample_surface(proxy[0], proxy[1], DISTANCE_SAMPLES, 0)
    added = np.linalg.norm(closest_on_surface(made, points, triangles)[0] - made, axis=1)
    if max(np.percentile(missing, P95), np.percentile(added, P95)) > VOXEL_TOLERANCE_CELLS * proxy[2]:
        return None
    return Solid(proxy[0], proxy[1], kind="closed")


def _with_protruding(bodies: Bodies, united: Surface, size: float) -> tuple[Solid, str]:
    """The united bodies, with the hulls of open parts that reach beyond their box."""
    low, high = united[0].min(axis=0) - PROTRUDING * size, united[0].max(axis=0) + PROTRUDING * size
    hulls: list[Surface] = []
    for part in bodies.verdicts:
        points = bodies.open_surface[0][np.unique(bodies.open_surface[1][part.faces])]
        if (points < low).any() or (points > high).any():
            if _is_flat(points):
                points = _slab(points, _wall(size))
            hull = trimesh.PointCloud(points).convex_hull
            hulls.append((np.array(hull.vertices), np.array(hull.faces, dtype=np.int32)))
    both = unite([united, *hulls]) if hulls else None
    return (
        (Solid(*united, kind="closed"), "union") if both is None else (Solid(*both, kind="closed"), "union_and_hulls")
    )


def _wall(size: float) -> float:
    """The thickness assumed of a sheet in an asset with this diagonal."""
    return min(max(WALL_PER_DIAGONAL * size, LEAST_WALL_M), MOST_WALL_M)


def _slab(points: FloatArray, thickness: float) -> FloatArray:
    """A flat card given two faces, `thickness` apart along its thinnest direction."""
    centred = points - points.mean(axis=0)
    normal = np.linalg.eigh(centred.T @ centred)[1][:, 0]
    return np.concatenate([points - 0.5 * thickness * normal, points + 0.5 * thickness * normal])


def _is_flat(points: FloatArray) -> bool:
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    size = np.ptp(centred @ axes, axis=0)
    return bool(size.prod() < FLAT_SHARE * diagonal(points) ** 3)


def _volume(solid: Solid) -> float:
    if solid.wall_thickness_m is not None:
        return float(triangle_areas(solid.points[solid.triangles]).sum()) * solid.wall_thickness_m
    return signed_volume(solid.points, solid.triangles)
