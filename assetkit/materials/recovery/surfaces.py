"""The degraded surfaces of an object, each with what is known of it beside its colours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from assetkit.materials.recovery.degraded import DegradedMaterial, degraded_materials, degraded_meshes, trusted
from assetkit.materials.recovery.families import SurfaceClues
from assetkit.materials.recovery.rank import stated_colour
from assetkit.materials.surface_appearance import AppearanceSampler, SurfaceAppearance
from schemas.appearance.material import Material
from schemas.evidence import Evidence
from schemas.model import Mesh, Model
from schemas.parts import Part

_LABEL_SHARE = 0.9  # of the triangles of a mesh, from which the label of a part is that of the mesh
_CLOSED = 1e-3  # of the area: a closed surface has no area vector in total


@dataclass(frozen=True)
class RecoverySubject:
    """What is known of the object as a whole, and of its meshes by id.

    is_metric   whether its size in metres is likely right.     densities_kgm3  as the source states them.
    contacts    names of physical materials of the source.
    """

    category: Evidence[str]
    file_name: str
    folders: tuple[str, ...] = ()
    parts: Sequence[Evidence[Part]] = ()
    is_metric: bool = True
    densities_kgm3: Mapping[str, float] = field(default_factory=dict[str, float])
    contacts: Mapping[str, str] = field(default_factory=dict[str, str])


@dataclass(frozen=True)
class OpenSurface:
    """Meshes (ids) with one degraded material and the same clues; `colour` is the basic term that a name states."""

    degraded: DegradedMaterial
    meshes: tuple[str, ...]
    clues: SurfaceClues
    colour: str | None


def open_surfaces(model: Model, subject: RecoverySubject) -> tuple[OpenSurface, ...]:
    """The degraded surfaces of `model`, in the order of its degraded materials and meshes.

    Meshes of one material are separate where their clues differ.
    """
    surfaces: list[OpenSurface] = []
    for degraded in degraded_materials(model):
        meshes = degraded_meshes(model, degraded)
        appearance, dielectric = _stated(model, degraded, meshes)
        groups: dict[object, list[str]] = {}
        clues_of: dict[object, SurfaceClues] = {}
        for mesh in meshes:
            clues = _clues(mesh, model, degraded, subject)
            key = (clues.label, clues.own_names, clues.wall_mm, clues.density_kgm3)
            clues_of.setdefault(key, replace(clues, appearance=appearance, dielectric=dielectric))
            groups.setdefault(key, []).append(mesh.id)
        for key, ids in groups.items():
            clues = clues_of[key]
            surfaces.append(
                OpenSurface(degraded, tuple(ids), clues, stated_colour((*clues.own_names, *clues.of_whole[:1])))
            )
    return tuple(surfaces)


def _clues(mesh: Mesh, model: Model, degraded: DegradedMaterial, subject: RecoverySubject) -> SurfaceClues:
    part = _part_of(mesh, subject.parts)
    label = part.label.value if part is not None and part.label.confidence > 0.0 else ""
    names = (
        "" if degraded.index is None else model.materials[degraded.index].name,
        subject.contacts.get(mesh.id, ""),
        mesh.name,
        mesh.source_path.rpartition("/")[2],
        part.name if part is not None else "",
    )
    wall = wall_mm(mesh) if subject.is_metric else None
    return SurfaceClues(
        label=label,
        own_names=tuple(dict.fromkeys(name for name in names if name)),
        of_whole=(subject.file_name, *subject.folders),
        wall_mm=None if wall is None else float(f"{wall:.1g}"),
        density_kgm3=subject.densities_kgm3.get(mesh.id),
    )


def wall_mm(mesh: Mesh) -> float | None:
    """Twice the volume over the area of a closed mesh in metres, in millimetres: its wall where it is thin.

    None for an open mesh, and for one with no volume.
    """
    a, b, c = (mesh.points[mesh.triangles[:, corner]] for corner in range(3))
    vectors = np.cross(b - a, c - a) / 2.0
    area = float(np.linalg.norm(vectors, axis=1).sum())
    volume = abs(float(np.einsum("mk,mk->", a, np.cross(b, c)))) / 6.0
    if not (area > 0.0 and volume > 0.0) or float(np.linalg.norm(vectors.sum(axis=0))) > _CLOSED * area:
        return None
    return 2000.0 * volume / area


def _part_of(mesh: Mesh, parts: Sequence[Evidence[Part]]) -> Part | None:
    """The smallest part that holds nearly all of a mesh."""
    holding = [
        part.value
        for part in parts
        if sum(len(f.indices) for f in part.value.faces if f.mesh == mesh.id) >= _LABEL_SHARE * len(mesh.triangles)
    ]
    return min(holding, key=lambda part: (part.area_m2, part.part_id), default=None)


def _stated(model: Model, degraded: DegradedMaterial, meshes: Sequence[Mesh]) -> tuple[SurfaceAppearance, bool]:
    """The appearance of the trustworthy values of a degraded material alone, and whether they state no metal."""
    if degraded.index is None:
        return SurfaceAppearance(), False
    material = model.materials[degraded.index]
    stated = trustworthy_part(material, degraded.fields)
    dielectric = "metallic" not in degraded.fields and material.metallic == 0.0 and trusted(material, "metallic")
    if all(name in degraded.fields for name in ("base_color", "metallic", "roughness")):
        return SurfaceAppearance(), dielectric
    materials = tuple(stated if k == degraded.index else each for k, each in enumerate(model.materials))
    sampler = AppearanceSampler(replace(model, materials=materials))
    return sampler.of([(mesh, np.arange(len(mesh.triangles))) for mesh in meshes]), dielectric


def trustworthy_part(material: Material, open_fields: Sequence[str]) -> Material:
    """`material` with its open fields at the values of a plain one."""
    plain = Material(material.name)
    return replace(material, **{name: getattr(plain, name) for name in open_fields})
