"""Division of the volume of a solid (m3) among groups of its visual meshes, so that each can have its own density."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import manifold3d
import numpy as np

from geom.mass.inertia import enclosed_volume, sheet_volume
from geom.mesh.edit import merge_surfaces
from geom.mesh.surface_distance import triangle_areas
from geom.repair.holes import capped_body
from geom.solid.closed_bodies import Bodies, Surface, as_manifold, outward, sort_bodies
from geom.solid.open_parts import wall_bodies
from geom.solid.solid_volume import volume_properties
from schemas.arrays import FloatArray
from schemas.model import Mesh
from schemas.physics import Solid, VolumeProperties

# The bodies of the groups must add up to the solid within this share of it; else the division is by area.
SUM_TOLERANCE = 0.02
# Shared volume below this share of the whole is ignored; a body left with less than this share of its own volume counts
# as vanished.
LEAST_SHARED, VANISHING = 1e-3, 1e-2
NOTHING = VolumeProperties(0.0, np.zeros(3), np.zeros((3, 3)))


@dataclass(frozen=True)
class VolumeShares:
    """One volume per group, together as large as the solid.

    exact        the bodies are separate regions; else they are shares by visible area.
    alternative  the bodies when shared volume goes to the other group; None when the groups share none, or when
                 a group would vanish then.
    reason       why the shared volume was assigned so; "" when there is none.
    """

    shares: tuple[VolumeProperties, ...]
    exact: bool
    alternative: tuple[VolumeProperties, ...] | None = None
    reason: str = ""


def divide_volume(solid: Solid, groups: Sequence[Sequence[Mesh]], densities_kgm3: Sequence[float]) -> VolumeShares:
    """The shares of `groups` of meshes in the volume of `solid`.

    Closed: each group's closed bodies, with walls grown from its sheets if the solid has such; if these do not add up,
    also its open surfaces with every loop capped (one skin painted with two materials is cut along the paint). Where
    bodies overlap, the denser keeps the shared volume, as a bolt displaces the wood around it; but the lighter does
    where it lies wholly inside the denser (foam in a steel case), since nothing would be left of it; among equals the
    group listed first. Shell: each group's sheets. When neither adds up to the solid, and for hulls, every group gets
    the share of the whole body that it has of the visible area, spread evenly. Raises ValueError when all points
    coincide.
    """
    whole = volume_properties(solid)[0]
    bodies = [sort_bodies(meshes) for meshes in groups]
    for attempt in _attempts(solid, bodies, densities_kgm3):
        total = sum(share.volume_m3 for share in attempt.shares)
        if abs(total - whole.volume_m3) <= SUM_TOLERANCE * whole.volume_m3:
            factor = whole.volume_m3 / total
            alternative = (
                None if attempt.alternative is None else tuple(share.share(factor) for share in attempt.alternative)
            )
            return replace(
                attempt, shares=tuple(share.share(factor) for share in attempt.shares), alternative=alternative
            )
    areas = np.array([group.closed_area + group.open_area for group in bodies])
    return VolumeShares(tuple(whole.share(float(share)) for share in areas / areas.sum()), False)


def _attempts(solid: Solid, groups: Sequence[Bodies], densities_kgm3: Sequence[float]) -> Iterator[VolumeShares]:
    """Divisions with a separate region for each group, the simplest first."""
    if solid.kind == "closed":
        if solid.wall_thickness_m is not None:
            wall_m = solid.wall_thickness_m
            yield _volumes([(*group.closed, *wall_bodies(group, wall_m)) for group in groups], densities_kgm3)
        yield _volumes([group.closed for group in groups], densities_kgm3)
        yield _volumes([(*group.closed, *_capped_sheets(group)) for group in groups], densities_kgm3)
    elif solid.wall_thickness_m is not None:
        yield VolumeShares(tuple(_sheet(group, solid.wall_thickness_m) for group in groups), True)


def _volumes(groups: Sequence[Sequence[Surface]], densities_kgm3: Sequence[float]) -> VolumeShares:
    """Per group the volume outside all groups before it: the densest first; as the alternative, the lightest first."""
    points = [points for group in groups for points, _ in group]
    centre = np.concatenate(points).mean(axis=0) if points else np.zeros(3)
    solids = [
        manifold3d.Manifold.batch_boolean([as_manifold(p - centre, t) for p, t in group], manifold3d.OpType.Add)
        for group in groups
    ]
    dense_first = sorted(range(len(groups)), key=lambda i: -densities_kgm3[i])
    shares, alternative = (_in_order(solids, order, centre) for order in (dense_first, dense_first[::-1]))
    shared = sum(abs(a.volume_m3 - b.volume_m3) for a, b in zip(shares, alternative, strict=True))
    if shared <= LEAST_SHARED * sum(share.volume_m3 for share in shares):
        return VolumeShares(shares, True)
    full, alternative_full = (_nothing_vanishes(solids, division) for division in (shares, alternative))
    if alternative_full and not full:
        return VolumeShares(alternative, True, None, "what lies inside another body keeps its place")
    return VolumeShares(shares, True, alternative if alternative_full else None, "the denser body keeps what two share")


def _in_order(
    solids: Sequence[manifold3d.Manifold], order: Sequence[int], centre: FloatArray
) -> tuple[VolumeProperties, ...]:
    """Per solid the part outside those before it in `order`; empty where it is no manifold."""
    shares, taken = [NOTHING] * len(solids), manifold3d.Manifold()
    for index in order:
        shares[index] = _integrated(solids[index] - taken, centre)
        taken = taken + solids[index]
    return tuple(shares)


def _nothing_vanishes(solids: Sequence[manifold3d.Manifold], shares: Sequence[VolumeProperties]) -> bool:
    return all(
        share.volume_m3 >= VANISHING * solid.volume()
        for solid, share in zip(solids, shares, strict=True)
        if solid.volume() > 0.0
    )


def _integrated(body: manifold3d.Manifold, centre: FloatArray) -> VolumeProperties:
    if body.is_empty():
        return NOTHING
    mesh = body.to_mesh64()
    points, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64)
    local = enclosed_volume(points, triangles)
    return replace(local, centre_m=local.centre_m + centre)


def _capped_sheets(bodies: Bodies) -> Iterator[Surface]:
    """Each open surface with all its loops capped, outward."""
    for part in bodies.open_bodies:
        if part.openings and part.complete:
            yield outward(*capped_body(*bodies.open_surface, part))


def _sheet(bodies: Bodies, wall_m: float) -> VolumeProperties:
    points, triangles, _ = merge_surfaces(bodies.tidied)
    return sheet_volume(points, triangles, wall_m) if triangle_areas(points[triangles]).any() else NOTHING
