"""What each collision shape is made of where it can be touched: the material of the parts it stands for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from assetkit.mass import MassEvidence
from assetkit.mass_parts import Clues
from assetkit.source_contacts import contact_evidence
from geom.mesh_edit import merge_surfaces
from geom.support import surface
from geom.surface_distance import NearestOnSurface, sample_surface, triangle_areas
from schemas.asset import ColliderMaterial, MassPart
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import FloatArray, Mesh
from schemas.outcome import Repair
from schemas.physics import CollisionShape, Contact, Solid, SurfaceMaterial
from schemas.stated_physics import StatedContact

SAMPLES = 4000
# A shape of which less than this share of the surface is of another material stands for one part.
MIXED_SHARE = 0.1


@dataclass(frozen=True)
class Touches:
    """How a body touches: its contact records, its parts with theirs, and the material of each collision shape.

    `surfaces`, `shape_surfaces` (see `schemas.package.PackageContent`) and `colliders` are empty where all is one part.
    """

    contacts: tuple[Evidence[Contact], ...]
    parts: tuple[MassPart, ...]
    surfaces: tuple[SurfaceMaterial, ...] = ()
    shape_surfaces: tuple[int, ...] = ()
    colliders: tuple[ColliderMaterial, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


def touches(
    shapes: Sequence[CollisionShape],
    solid: Solid,
    mass: MassEvidence,
    clues: Clues,
    stated: Sequence[StatedContact],
) -> Touches:
    """Contact of a body whose parts have masses as in `mass`; `stated` is what the source says about friction.

    Each shape has the material of the part that most of its surface belongs to (`surface_shares`), one hidden inside
    others that of the largest part, which is also the one that an engine with one material per body should take.
    """
    if len(mass.parts) < 2:
        one = contact_evidence(mass.material, stated, clues.as_read)
        return Touches(one.contacts, mass.parts, diagnostics=one.diagnostics, repairs=one.repairs)
    order = sorted(range(len(mass.parts)), key=lambda i: -mass.parts[i].volume_share)
    meshes = [[(clues.as_read or clues.meshes)[m] for m in mass.members[i]] for i in order]
    found = [contact_evidence(mass.parts[i].material, stated, own) for i, own in zip(order, meshes, strict=True)]
    parts = [mass.parts[i].model_copy(update={"contacts": f.contacts}) for i, f in zip(order, found, strict=True)]
    names = [part.material.value for part in parts]
    shares = surface_shares(shapes, solid, [[clues.meshes[m] for m in mass.members[i]] for i in order])
    chosen = tuple(int(k) for k in shares.argmax(axis=1))  # The first of equals: the largest part where there is none.
    surfaces = zip(names, parts, found, strict=True)
    return Touches(
        found[0].contacts,
        tuple(parts[order.index(i)] for i in range(len(parts))),
        tuple(
            SurfaceMaterial(name, part.density_kgm3.value, touch.contacts[0].value) for name, part, touch in surfaces
        ),
        chosen,
        tuple(
            ColliderMaterial(collider=f"collider_{k:02d}", material=names[chosen[k]], shares=_by_name(names, row))
            for k, row in enumerate(shares)
        ),
        (*(d for f in found for d in f.diagnostics), *mixed_note(shares, chosen, names)),
        tuple(r for f in found for r in f.repairs),
    )


def surface_shares(shapes: Sequence[CollisionShape], solid: Solid, groups: Sequence[Sequence[Mesh]]) -> FloatArray:
    """(s, g) how much of what can be touched of each shape belongs to each group of visual meshes; rows sum to 1.

    Points spread evenly over the surface of `solid` belong to the group whose faces lie nearest, and to the shape whose
    side lies nearest. A shape that no point belongs to, inside others, has a row of zeros.
    """
    touched, _ = sample_surface(solid.points, solid.triangles, SAMPLES, 0)
    group = np.argmin([_distance(touched, meshes) for meshes in groups], axis=0)
    shape = np.argmin([np.abs(_height_over(shape, touched)) for shape in shapes], axis=0)
    counts = np.zeros((len(shapes), len(groups)))
    np.add.at(counts, (shape, group), 1.0)
    return counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)


def mixed_note(shares: FloatArray, chosen: Sequence[int], names: Sequence[str]) -> tuple[Diagnostic, ...]:
    """What is told when shapes cover more than one material; `chosen` groups by shape, `names` of the groups."""
    other = np.where(shares.sum(axis=1) > 0.0, 1.0 - shares[np.arange(len(chosen)), list(chosen)], 0.0)
    mixed = np.flatnonzero(other > MIXED_SHARE)
    if not mixed.size:
        return ()
    worst = int(mixed[np.argmax(other[mixed])])
    covered = " and ".join(name for name, share in zip(names, shares[worst], strict=True) if share > 0.0)
    headline = f"collider_{worst:02d} covers {covered}; it touches as {names[chosen[worst]]}"
    return (
        finding(
            "asset/mixed-collider",
            headline,
            value=float(other[worst]),
            bound=MIXED_SHARE,
            unit="of its surface",
        ),
    )


def _by_name(names: Sequence[str], shares: FloatArray) -> dict[str, float]:
    return {name: round(sum(float(s) for n, s in zip(names, shares, strict=True) if n == name), 4) for name in names}


def _distance(points: FloatArray, meshes: Sequence[Mesh]) -> FloatArray:
    """(k,) from each of `points` (k, 3) to the nearest face of `meshes`; infinite where they have no area."""
    corners, triangles, _ = merge_surfaces(meshes)
    if not triangle_areas(corners[triangles]).any():
        return np.full(len(points), np.inf)
    return np.linalg.norm(NearestOnSurface(corners, triangles)(points)[0] - points, axis=1)


def _height_over(shape: CollisionShape, points: FloatArray) -> FloatArray:
    """(k,) how far `points` (k, 3) stand out of the outermost side of a convex shape; negative inside."""
    try:
        sides = ConvexHull(surface(shape)[0]).equations
    except QhullError:
        return np.full(len(points), np.inf)
    return (points @ sides[:, :3].T + sides[:, 3]).max(axis=1)
