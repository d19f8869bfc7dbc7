"""How the volume of a solid divides among groups of its visual meshes, so that each can have its own density."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import manifold3d
import numpy as np

from geom.inertia import mass_properties, of_closed_surface, of_sheet, scaled
from geom.mesh_edit import keep_faces, merge_surfaces
from geom.repair_holes import cap_openings
from geom.solid_bodies import Bodies, Surface, as_manifold, signed_volume, sort_bodies
from geom.surface_distance import triangle_areas
from schemas.model import FloatArray, Mesh
from schemas.physics import MassProperties, Solid

# The groups' own bodies must add up to the solid within this share of it, else they are not what it is made of.
SUM_TOLERANCE = 0.02
NOTHING = MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))


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
    bodies = [sort_bodies(meshes) for meshes in groups]
    for shares in _attempts(solid, bodies, densities_kgm3):
        total = sum(share.mass_kg for share in shares)
        if abs(total - whole.mass_kg) <= SUM_TOLERANCE * whole.mass_kg:
            return tuple(scaled(share, whole.mass_kg / total) for share in shares), True
    areas = np.array([group.closed_area + group.open_area for group in bodies])
    return tuple(scaled(whole, float(share)) for share in areas / areas.sum()), False


def _attempts(
    solid: Solid, groups: Sequence[Bodies], densities_kgm3: Sequence[float]
) -> Iterator[list[MassProperties]]:
    """Ways to give each group a place of its own, the plainest first."""
    if solid.kind == "closed":
        yield _volumes([group.closed for group in groups], densities_kgm3)
        yield _volumes([(*group.closed, *_capped_sheets(group)) for group in groups], densities_kgm3)
    elif solid.wall_thickness_m is not None:
        yield [_sheet(group, solid.wall_thickness_m) for group in groups]


def _volumes(groups: Sequence[Sequence[Surface]], densities_kgm3: Sequence[float]) -> list[MassProperties]:
    """Per group the volume that no denser group holds; nothing where a surface is no manifold."""
    shares, taken = [NOTHING] * len(groups), manifold3d.Manifold()
    points = [points for group in groups for points, _ in group]
    centre = np.concatenate(points).mean(axis=0) if points else np.zeros(3)
    for index in sorted(range(len(groups)), key=lambda i: -densities_kgm3[i]):
        solids = [as_manifold(points - centre, triangles) for points, triangles in groups[index]]
        own = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
        shares[index] = _integrated(own - taken, centre)
        taken = taken + own
    return shares


def _integrated(body: manifold3d.Manifold, centre: FloatArray) -> MassProperties:
    if body.is_empty():
        return NOTHING
    mesh = body.to_mesh64()
    points, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
    local = of_closed_surface(points, triangles, 1.0)
    return MassProperties(local.mass_kg, local.centre_of_mass_m + centre, local.inertia_kgm2)


def _capped_sheets(bodies: Bodies) -> Iterator[Surface]:
    """Each open surface with all its loops capped, outward."""
    for part in bodies.verdicts:
        if part.openings and part.complete:
            points, triangles = bodies.open_surface
            sheet = keep_faces(Mesh("part", points, triangles), part.faces)
            points, triangles, _ = cap_openings(sheet.points, sheet.triangles, part.openings)
            yield points, triangles if signed_volume(points, triangles) >= 0.0 else triangles[:, ::-1]


def _sheet(bodies: Bodies, wall_m: float) -> MassProperties:
    points, triangles, _ = merge_surfaces(bodies.tidied)
    return of_sheet(points, triangles, wall_m, 1.0) if triangle_areas(points[triangles]).any() else NOTHING
