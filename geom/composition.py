"""How the volume of a solid divides among groups of its visual meshes, so that each can have its own density."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np

from geom.inertia import mass_properties, of_closed_surface, of_sheet, scaled
from geom.mesh_edit import keep_faces, merge_surfaces
from geom.openings import OpenBody
from geom.repair_holes import cap_openings
from geom.solid_bodies import Bodies, Surface, as_manifold, signed_volume, sort_bodies
from geom.surface_distance import triangle_areas
from schemas.model import FloatArray, Mesh
from schemas.physics import MassProperties, Solid

# The groups' own bodies must add up to the solid within this share of it, else they are not what it is made of.
SUM_TOLERANCE = 0.02


def divide(
    solid: Solid, groups: Sequence[Sequence[Mesh]], densities_kgm3: Sequence[float]
) -> tuple[tuple[MassProperties, ...], bool]:
    """One body of 1 kg/m3 per group (its mass is its volume in m3), together as large as `solid`; and whether they
    have places of their own.

    Closed: each group's closed bodies; if these do not add up, also its open surfaces with every loop capped (one skin
    painted with two materials is cut along the paint). Where bodies overlap, the denser keeps the shared volume, as a
    bolt displaces the wood around it; among equals the group listed first. Shell: each group's sheets. When neither
    adds up to the solid, and for hulls, every group gets the share of the whole body that it has of the visible area,
    spread evenly, and the second value is False. Raises ValueError when all points coincide.
    """
    whole = mass_properties(solid, 1.0)[0]
    sorted_groups = [sort_bodies(meshes) for meshes in groups]
    attempts = []
    if solid.kind == "closed":
        attempts = [lambda: _volumes(sorted_groups, densities_kgm3, _closed)]
        attempts += [lambda: _volumes(sorted_groups, densities_kgm3, _closed_and_capped)]
    elif solid.wall_thickness_m is not None:
        wall = solid.wall_thickness_m
        attempts = [lambda: [_sheet(bodies, wall) for bodies in sorted_groups]]
    for attempt in attempts:
        bodies = attempt()
        total = sum(b.mass_kg for b in bodies)
        if abs(total - whole.mass_kg) <= SUM_TOLERANCE * whole.mass_kg:
            return tuple(scaled(b, whole.mass_kg / total) for b in bodies), True
    areas = np.array([bodies.closed_area + bodies.open_area for bodies in sorted_groups])
    return tuple(scaled(whole, float(share)) for share in areas / areas.sum()), False


def _volumes(groups: Sequence[Bodies], densities_kgm3: Sequence[float], surfaces_of) -> list[MassProperties]:
    """Per group the volume that no denser group holds; nothing for a group with a surface that is no manifold."""
    surfaces = [surfaces_of(bodies) for bodies in groups]
    points = [p for group in surfaces for p, _ in group]
    nothing = MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))
    if not points:
        return [nothing] * len(groups)
    centre = np.concatenate(points).mean(axis=0)
    shares, taken = [nothing] * len(groups), manifold3d.Manifold()
    for index in sorted(range(len(groups)), key=lambda i: -densities_kgm3[i]):
        solids = [as_manifold(p - centre, triangles) for p, triangles in surfaces[index]]
        own = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
        shares[index] = _integrated(own - taken, centre)
        taken = taken + own
    return shares


def _integrated(body: manifold3d.Manifold, centre: FloatArray) -> MassProperties:
    mesh = body.to_mesh64()
    points = np.asarray(mesh.vert_properties)[:, :3]
    if body.is_empty() or len(points) == 0:
        return MassProperties(0.0, centre, np.zeros((3, 3)))
    local = of_closed_surface(points, np.asarray(mesh.tri_verts).astype(np.int64), 1.0)
    return MassProperties(local.mass_kg, local.centre_of_mass_m + centre, local.inertia_kgm2)


def _closed(bodies: Bodies) -> list[Surface]:
    return list(bodies.closed)


def _closed_and_capped(bodies: Bodies) -> list[Surface]:
    """The closed bodies, and each open surface with all its loops capped, outward."""
    return [*bodies.closed, *(_capped(bodies, part) for part in bodies.verdicts if part.openings and part.complete)]


def _capped(bodies: Bodies, part: OpenBody) -> Surface:
    points, triangles = bodies.open_surface
    sheet = keep_faces(Mesh("part", points, triangles), part.faces)
    points, triangles, _ = cap_openings(sheet.points, sheet.triangles, part.openings)
    return points, triangles if signed_volume(points, triangles) >= 0.0 else triangles[:, ::-1]


def _sheet(bodies: Bodies, wall_m: float) -> MassProperties:
    points, triangles, _ = merge_surfaces(bodies.tidied)
    if not triangle_areas(points[triangles]).any():
        return MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))
    return of_sheet(points, triangles, wall_m, 1.0)
