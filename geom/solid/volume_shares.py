"""How the volume of a solid divides among groups of its visual meshes, so that each can have its own density."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import manifold3d
import numpy as np

from geom.mass.inertia import mass_properties, of_closed_surface, of_sheet, scaled
from geom.mesh.edit import merge_surfaces
from geom.mesh.surface_distance import triangle_areas
from geom.repair.holes import capped_body
from geom.solid.closed_bodies import Bodies, Surface, as_manifold, outward, sort_bodies
from geom.solid.open_parts import wall_bodies
from schemas.model import FloatArray, Mesh
from schemas.physics import MassProperties, Solid

# The groups' own bodies must add up to the solid within this share of it, else they are not what it is made of.
SUM_TOLERANCE = 0.02
# Volume that groups share matters from this share of the whole on; of a body left with less than this share of its own
# nothing is left.
LEAST_SHARED, VANISHING = 1e-3, 1e-2
NOTHING = MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))


@dataclass(frozen=True)
class Division:
    """One body of 1 kg/m3 per group (its mass is its volume in m3), together as large as the solid.

    exact    the bodies have places of their own; else they are shares by visible area.
    rival    the bodies as they are when volume that groups share goes to the others; None when they share none, or when
             nothing would be left of a group then.
    reason   why the shared volume goes where it goes; "" when there is none.
    """

    shares: tuple[MassProperties, ...]
    exact: bool
    rival: tuple[MassProperties, ...] | None = None
    reason: str = ""


def divide(solid: Solid, groups: Sequence[Sequence[Mesh]], densities_kgm3: Sequence[float]) -> Division:
    """How `solid` divides among `groups` of its meshes.

    Closed: each group's closed bodies, with walls grown from its sheets if the solid has such; if these do not add up,
    also its open surfaces with every loop capped (one skin painted with two materials is cut along the paint). Where
    bodies overlap, the denser keeps the shared volume, as a bolt displaces the wood around it; but the lighter does
    where it lies wholly inside the denser (foam in a steel case), since nothing would be left of it; among equals the
    group listed first. Shell: each group's sheets. When neither adds up to the solid, and for hulls, every group gets
    the share of the whole body that it has of the visible area, spread evenly. Raises ValueError when all points
    coincide.
    """
    whole = mass_properties(solid, 1.0)[0]
    bodies = [sort_bodies(meshes) for meshes in groups]
    for made in _attempts(solid, bodies, densities_kgm3):
        total = sum(share.mass_kg for share in made.shares)
        if abs(total - whole.mass_kg) <= SUM_TOLERANCE * whole.mass_kg:
            factor = whole.mass_kg / total
            rival = None if made.rival is None else tuple(scaled(share, factor) for share in made.rival)
            return replace(made, shares=tuple(scaled(share, factor) for share in made.shares), rival=rival)
    areas = np.array([group.closed_area + group.open_area for group in bodies])
    return Division(tuple(scaled(whole, float(share)) for share in areas / areas.sum()), False)


def _attempts(solid: Solid, groups: Sequence[Bodies], densities_kgm3: Sequence[float]) -> Iterator[Division]:
    """Ways to give each group a place of its own, the plainest first."""
    if solid.kind == "closed":
        if solid.wall_thickness_m is not None:
            wall_m = solid.wall_thickness_m
            yield _volumes([(*group.closed, *wall_bodies(group, wall_m)) for group in groups], densities_kgm3)
        yield _volumes([group.closed for group in groups], densities_kgm3)
        yield _volumes([(*group.closed, *_capped_sheets(group)) for group in groups], densities_kgm3)
    elif solid.wall_thickness_m is not None:
        yield Division(tuple(_sheet(group, solid.wall_thickness_m) for group in groups), True)


def _volumes(groups: Sequence[Sequence[Surface]], densities_kgm3: Sequence[float]) -> Division:
    """Per group the volume that no group before it holds, the densest first and, as the rival, the lightest first."""
    points = [points for group in groups for points, _ in group]
    centre = np.concatenate(points).mean(axis=0) if points else np.zeros(3)
    solids = [
        manifold3d.Manifold.batch_boolean([as_manifold(p - centre, t) for p, t in group], manifold3d.OpType.Add)
        for group in groups
    ]
    dense_first = sorted(range(len(groups)), key=lambda i: -densities_kgm3[i])
    shares, rival = (_in_order(solids, order, centre) for order in (dense_first, dense_first[::-1]))
    shared = sum(abs(a.mass_kg - b.mass_kg) for a, b in zip(shares, rival, strict=True))
    if shared <= LEAST_SHARED * sum(share.mass_kg for share in shares):
        return Division(shares, True)
    full, rival_full = (_nothing_vanishes(solids, division) for division in (shares, rival))
    if rival_full and not full:
        return Division(rival, True, None, "what lies inside another body keeps its place")
    return Division(shares, True, rival if rival_full else None, "the denser body keeps what two share")


def _in_order(
    solids: Sequence[manifold3d.Manifold], order: Sequence[int], centre: FloatArray
) -> tuple[MassProperties, ...]:
    """Per solid what those before it in `order` leave of it; nothing where it is no manifold."""
    shares, taken = [NOTHING] * len(solids), manifold3d.Manifold()
    for index in order:
        shares[index] = _integrated(solids[index] - taken, centre)
        taken = taken + solids[index]
    return tuple(shares)


def _nothing_vanishes(solids: Sequence[manifold3d.Manifold], shares: Sequence[MassProperties]) -> bool:
    return all(
        share.mass_kg >= VANISHING * solid.volume()
        for solid, share in zip(solids, shares, strict=True)
        if solid.volume() > 0.0
    )


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
            yield outward(*capped_body(*bodies.open_surface, part))


def _sheet(bodies: Bodies, wall_m: float) -> MassProperties:
    points, triangles, _ = merge_surfaces(bodies.tidied)
    return of_sheet(points, triangles, wall_m, 1.0) if triangle_areas(points[triangles]).any() else NOTHING
