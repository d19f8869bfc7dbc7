"""What each collision shape is made of where it can be touched: the material of the parts it stands for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from assetkit.mass.estimate import MassEvidence
from assetkit.mass.parts import Clues
from assetkit.physics.source_contacts import contact_evidence
from geom.convex.support_function import surface
from geom.mesh.edit import merge_surfaces
from geom.mesh.surface_distance import NearestOnSurface, sample_surface, triangle_areas
from schemas.asset import ColliderMaterial, MassPart
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import FloatArray, IntArray, Mesh
from schemas.outcome import Repair
from schemas.physics import CollisionShape, Contact, Solid, SurfaceMaterial
from schemas.stated_physics import StatedContact

SAMPLES = 4000
# A shape of which less than this share of the surface is of another material stands for one part.
MIXED_SHARE = 0.1
LEAST_SKIN = 0.05  # of a part's surface; what is smaller does not touch as itself


@dataclass(frozen=True)
class Touches:
    """How a body touches: contact records and material of most of it, its parts with theirs, those of shapes.

    `surfaces`, `shape_surfaces` (see `schemas.package.PackageContent`) and `colliders` are empty where all is one part.
    """

    contacts: tuple[Evidence[Contact], ...]
    material: Evidence[str]
    parts: tuple[MassPart, ...]
    surfaces: tuple[SurfaceMaterial, ...] = ()
    shape_surfaces: tuple[int, ...] = ()
    colliders: tuple[ColliderMaterial, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()


@dataclass(frozen=True)
class Skin:
    """Visible surface of one material: of which part of the mass, its triangles, and the meshes as they were read."""

    part: int
    material: Evidence[str]
    meshes: tuple[Mesh, ...]
    as_read: tuple[Mesh, ...]


def touches(
    shapes: Sequence[CollisionShape],
    solid: Solid,
    mass: MassEvidence,
    clues: Clues,
    stated: Sequence[StatedContact],
) -> Touches:
    """Contact of a body whose parts have masses as in `mass`; `stated` is what the source says about friction.

    Each shape has the material of the skin that most of its surface belongs to (`surface_shares`), one hidden inside
    others that of the largest part, which is also the one that an engine with one material per body should take.
    """
    skins = skins_of(mass, clues)
    most = skins[0].material
    found = [contact_evidence(skin.material, stated, skin.as_read) for skin in skins]
    own = [next(f.contacts for f, s in zip(found, skins, strict=True) if s.part == i) for i in range(len(mass.parts))]
    if len(skins) < 2:
        return Touches(found[0].contacts, most, mass.parts, diagnostics=found[0].diagnostics, repairs=found[0].repairs)
    names = [skin.material.value for skin in skins]
    shares = surface_shares(shapes, solid, [skin.meshes for skin in skins])
    chosen = tuple(int(k) for k in shares.argmax(axis=1))  # The first of equals: the largest part where there is none.
    return Touches(
        found[0].contacts,
        most,
        tuple(p.model_copy(update={"contacts": c}) for p, c in zip(mass.parts, own, strict=True)),
        tuple(
            SurfaceMaterial(name, mass.parts[skin.part].density_kgm3.value, touch.contacts[0].value)
            for name, skin, touch in zip(names, skins, found, strict=True)
        ),
        chosen,
        tuple(
            ColliderMaterial(collider=f"collider_{k:02d}", material=names[chosen[k]], shares=_by_name(names, row))
            for k, row in enumerate(shares)
        ),
        (*(d for f in found for d in f.diagnostics), *mixed_note(shares, chosen, names)),
        tuple(r for f in found for r in f.repairs),
    )


def skins_of(mass: MassEvidence, clues: Clues) -> tuple[Skin, ...]:
    """The visible surface by part of the mass and by material, the part with most volume first.

    A part whose names tell its material is of that throughout. Others are as they look (`clues.touch`), the skin with
    most area first; what takes less than 5 % of the part's surface goes to its largest.
    """
    found: list[Skin] = []
    for part in sorted(range(len(mass.parts)), key=lambda i: -mass.parts[i].volume_share):
        members = mass.members[part] if mass.members else ()
        named, as_read = mass.parts[part].material, clues.as_read or clues.meshes
        every = tuple(clues.meshes[m] for m in members)
        whole = Skin(part, named, every, tuple(as_read[m] for m in members))
        if named.source != "default" or not clues.touch or not members:
            found.append(whole)
            continue
        area = np.zeros(len(clues.touch))
        for m in members:
            mesh = clues.meshes[m]
            np.add.at(area, clues.of_face[m], triangle_areas(mesh.points[mesh.triangles]))
        first, *others = np.argsort(-area, kind="stable")
        kept = [int(k) for k in others if area[k] >= LEAST_SKIN * area.sum() > 0.0]
        for k in (int(first), *kept):
            own = [m for m in members if (_chosen(clues.of_face[m], k, kept)).any()]
            cut = tuple(_of_faces(clues.meshes[m], _chosen(clues.of_face[m], k, kept)) for m in own)
            found.append(Skin(part, clues.touch[k], cut or every, tuple(as_read[m] for m in own) or whole.as_read))
    return tuple(found)


def _chosen(of_face: IntArray, material: int, kept: Sequence[int]) -> IntArray:
    """(m,) True at the triangles of a material; the largest, which is not among `kept`, takes the rest."""
    return of_face == material if material in kept else ~np.isin(of_face, kept)


def _of_faces(mesh: Mesh, faces: IntArray) -> Mesh:
    return Mesh(mesh.name, mesh.points, mesh.triangles[faces], source_path=mesh.source_path)


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
