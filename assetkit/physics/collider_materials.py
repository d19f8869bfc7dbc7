"""Assigns a contact material to each collision shape: that of the visible surface nearest to most of its surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from assetkit.mass.estimate import MassEvidence
from assetkit.mass.parts import MassEvidenceInputs
from assetkit.physics.source_contacts import contact_evidence
from geom.convex.support_function import surface
from geom.mesh.edit import merge_surfaces
from geom.mesh.surface_distance import NearestOnSurface, sample_surface, triangle_areas
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.asset import ColliderMaterial, MassPart
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence
from schemas.model import Mesh
from schemas.outcome import Repair
from schemas.physics import CollisionShape, Contact, Solid, SurfaceMaterial
from schemas.stated_physics import StatedContact

TOUCH_SAMPLES = 4000
# A shape of which less than this share of the surface is of another material stands for one part.
MIXED_SHARE = 0.1
LEAST_REGION = 0.05  # of a part's surface; smaller regions go to the largest


@dataclass(frozen=True)
class ContactMaterials:
    """Contact materials of a body: contact records and material of most of it, those of its parts and of its shapes.

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
class MaterialRegion:
    """Visible surface of one material: index of its part of the mass, its triangles, and its meshes as read."""

    part: int
    material: Evidence[str]
    meshes: tuple[Mesh, ...]
    as_read: tuple[Mesh, ...]


def assign_contact_materials(
    shapes: Sequence[CollisionShape],
    solid: Solid,
    mass: MassEvidence,
    mass_inputs: MassEvidenceInputs,
    stated: Sequence[StatedContact],
) -> ContactMaterials:
    """Contact materials of a body whose parts are those of `mass`; `stated` holds the friction that the source states.

    Each shape has the material of the region that most of its surface belongs to (`surface_shares`), one hidden inside
    others that of the largest part, which is also the one that an engine with one material per body should take.
    """
    regions = material_regions(mass, mass_inputs)
    most = regions[0].material
    evidence = [contact_evidence(region.material, stated, region.as_read) for region in regions]
    of_parts = [
        next(e.contacts for e, region in zip(evidence, regions, strict=True) if region.part == i)
        for i in range(len(mass.parts))
    ]
    general = evidence[0]
    if len(regions) < 2:
        return ContactMaterials(
            general.contacts, most, mass.parts, diagnostics=general.diagnostics, repairs=general.repairs
        )
    names = [region.material.value for region in regions]
    shares = surface_shares(shapes, solid, [region.meshes for region in regions])
    chosen = tuple(int(k) for k in shares.argmax(axis=1))  # The first of equals: the largest part where there is none.
    return ContactMaterials(
        general.contacts,
        most,
        tuple(p.model_copy(update={"contacts": c}) for p, c in zip(mass.parts, of_parts, strict=True)),
        tuple(
            SurfaceMaterial(name, mass.parts[region.part].density_kgm3.value, e.contacts[0].value)
            for name, region, e in zip(names, regions, evidence, strict=True)
        ),
        chosen,
        tuple(
            ColliderMaterial(collider=f"collider_{k:02d}", material=names[chosen[k]], shares=_by_name(names, row))
            for k, row in enumerate(shares)
        ),
        (*(d for e in evidence for d in e.diagnostics), *mixed_collider_findings(shares, chosen, names)),
        tuple(r for e in evidence for r in e.repairs),
    )


def material_regions(mass: MassEvidence, mass_inputs: MassEvidenceInputs) -> tuple[MaterialRegion, ...]:
    """The visible surface by part of the mass and by material, the part with most volume first.

    A part with a material by name is of that throughout. Others have the materials of their faces
    (`surface_materials`), the largest region first; one of less than 5 % of the part's surface goes to the largest.
    """
    regions: list[MaterialRegion] = []
    for part in sorted(range(len(mass.parts)), key=lambda i: -mass.parts[i].volume_share):
        members = mass.members[part] if mass.members else ()
        named, as_read = mass.parts[part].material, mass_inputs.as_read or mass_inputs.meshes
        every = tuple(mass_inputs.meshes[m] for m in members)
        whole = MaterialRegion(part, named, every, tuple(as_read[m] for m in members))
        if named.source != "default" or not mass_inputs.surface_materials or not members:
            regions.append(whole)
            continue
        area = np.zeros(len(mass_inputs.surface_materials))
        for m in members:
            mesh = mass_inputs.meshes[m]
            np.add.at(area, mass_inputs.material_of_face[m], triangle_areas(mesh.points[mesh.triangles]))
        first, *others = np.argsort(-area, kind="stable")
        large = [int(k) for k in others if area[k] >= LEAST_REGION * area.sum() > 0.0]
        for k in (int(first), *large):
            masks = {m: _faces_of_material(mass_inputs.material_of_face[m], k, large) for m in members}
            cut = tuple(_submesh(mass_inputs.meshes[m], mask) for m, mask in masks.items() if mask.any())
            cut_as_read = tuple(as_read[m] for m, mask in masks.items() if mask.any())
            material = mass_inputs.surface_materials[k]
            regions.append(MaterialRegion(part, material, cut or every, cut_as_read or whole.as_read))
    return tuple(regions)


def _faces_of_material(material_of_face: IntArray, material: int, large: Sequence[int]) -> BoolArray:
    """(m,) True at the triangles of a material; the largest, which is not among `large`, takes the rest."""
    return material_of_face == material if material in large else ~np.isin(material_of_face, large)


def _submesh(mesh: Mesh, faces: BoolArray) -> Mesh:
    return Mesh(mesh.name, mesh.points, mesh.triangles[faces], source_path=mesh.source_path)


def surface_shares(shapes: Sequence[CollisionShape], solid: Solid, groups: Sequence[Sequence[Mesh]]) -> FloatArray:
    """(s, g) share of the outer surface of each shape that belongs to each group of visual meshes; rows sum to 1.

    Points spread evenly over the surface of `solid` belong to the group whose faces lie nearest, and to the shape whose
    side lies nearest. A shape that no point belongs to, inside others, has a row of zeros.
    """
    touched, _ = sample_surface(solid.points, solid.triangles, TOUCH_SAMPLES, 0)
    group = np.argmin([_distance(touched, meshes) for meshes in groups], axis=0)
    shape = np.argmin([np.abs(_height_over(shape, touched)) for shape in shapes], axis=0)
    counts = np.zeros((len(shapes), len(groups)))
    np.add.at(counts, (shape, group), 1.0)
    return counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)


def mixed_collider_findings(shares: FloatArray, chosen: Sequence[int], names: Sequence[str]) -> tuple[Diagnostic, ...]:
    """A finding when shapes cover several materials; `chosen` is the group of each shape, `names` those of groups."""
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
    """(k,) signed distance of `points` (k, 3) from the outermost plane of a convex shape; negative inside."""
    try:
        sides = ConvexHull(surface(shape)[0]).equations
    except QhullError:
        return np.full(len(points), np.inf)
    return (points @ sides[:, :3].T + sides[:, 3]).max(axis=1)
