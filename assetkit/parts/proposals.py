"""Proposals of part regions, from source nodes, render materials, connected surfaces and shape (metres)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from geom.features.axial_regions import neck_regions, regions_by_thickness, regions_by_width, stem_regions
from geom.features.protrusions import find_protrusions
from geom.features.regions import FaceGeometry, SurfaceRegion, boss_regions, face_geometry, plate_regions, side_regions
from geom.mesh.edges import edges_of, face_components
from geom.mesh.topology import repeats_point
from schemas.appearance.material import Material
from schemas.arrays import BoolArray, FloatArray, IntArray
from schemas.model import Mesh
from schemas.parts import ProposalSource

MOST_COMPONENTS = 24
# Where handle and spout both protrude, only the handle returns to the body.
_WITH_SPOUT = ("pitcher", "teapot")
_PIECES = ("hierarchy", "material", "component")
LEAST_SHARE = 0.002  # of the surface; what is smaller is no part of its own

# The shape detector of each category: elsewhere a bulge or a plate means nothing.
_SHAPE_DETECTORS: dict[str, Callable[[FaceGeometry], tuple[SurfaceRegion, ...]]] = {
    **dict.fromkeys(("table", "desk", "stool", "bench", "chair"), plate_regions),
    **dict.fromkeys(("bottle", "pill_bottle", "vase"), neck_regions),
    **dict.fromkeys(("spoon", "fork", "cooking_utensil", "hammer", "screwdriver", "scissors"), regions_by_width),
    "knife": regions_by_thickness,
    "drinking_glass": stem_regions,
    "block": boss_regions,
}
# What sticks out of a vessel: a round one by its outline, any other by its thickness.
_ROUND = ("mug", "cup", "pan", "pot", "pitcher", "teapot")
_WITH_LIMBS = (*_ROUND, "basket", "box", "bin", "tray")


@dataclass(frozen=True)
class Proposal:
    """`faces` (m,) True at its triangles, counted through all meshes; `names` what the source calls it; `role` what it
    is by shape, or a label of its own with its confidence from a learned segmenter, and `by` which one.
    """

    faces: BoolArray
    source: ProposalSource
    names: tuple[str, ...] = ()
    path: str = ""
    role: str = ""
    label: str = ""
    confidence: float = 0.0
    by: str = ""


@dataclass(frozen=True)
class SegmenterResult:
    """Proposals of a segmenter, with source `learned`; `problem` explains why there are none, or fewer than it gave."""

    proposals: tuple[Proposal, ...] = ()
    problem: str = ""


class Segmenter(Protocol):
    """A learned segmenter: regions of a surface with the part names of a vocabulary. Deterministic, never raises."""

    def segment(self, surface: FaceGeometry, category: str, vocabulary: Sequence[str]) -> SegmenterResult:
        """Regions of the surface; labels outside `vocabulary` are left out by the caller."""
        ...


def join_meshes(meshes: Sequence[Mesh]) -> FaceGeometry:
    """One surface of all meshes, triangles in order."""
    starts = np.cumsum([0, *(len(m.points) for m in meshes)])
    triangles = np.concatenate([m.triangles + s for m, s in zip(meshes, starts, strict=False)])
    return face_geometry(np.concatenate([m.points for m in meshes]), triangles)


def propose(
    surface: FaceGeometry,
    meshes: Sequence[Mesh],
    materials: Sequence[Material],
    category: str,
    vocabulary: Sequence[str],
    learned: Sequence[Proposal] = (),
    openings: Sequence[FloatArray] = (),
) -> list[Proposal]:
    """All proposals by source, by shape and those `learned` by a segmenter; none is the whole object."""
    owner = np.repeat(np.arange(len(meshes)), [len(m.triangles) for m in meshes])
    proposals = [*_by_node(meshes, owner), *_by_material(meshes, materials, owner), *_by_component(surface)]
    shaped = _regions_by_shape(surface, category, openings)
    if shaped:
        sure = category not in _WITH_SPOUT or sorted(r.role for r in shaped) in (["loop"], ["arm", "loop"])
        proposals += [Proposal(r.faces, "shape", role=r.role if sure else "") for r in shaped]
    proposals += [p for p in learned if p.label in ("", *vocabulary)]
    proposals = [replace(p, role=_role_of_piece(surface, p.faces)) if p.source in _PIECES else p for p in proposals]
    total = surface.area.sum()
    return [p for p in proposals if LEAST_SHARE * total < surface.area[p.faces].sum() < 0.98 * total]


def _regions_by_shape(
    surface: FaceGeometry, category: str, openings: Sequence[FloatArray]
) -> tuple[SurfaceRegion, ...]:
    """Regions by shape, of the kinds that things of the category have."""
    if category in _SHAPE_DETECTORS:
        return _SHAPE_DETECTORS[category](surface)
    regions = side_regions(surface) if category in _ROUND else ()
    if regions or category not in _WITH_LIMBS:
        return regions
    # A flap of a box or the lip of a tray is no limb that anything is known of; a bow is held.
    return tuple(r for r in find_protrusions(surface, openings) if category in _ROUND or r.role == "loop")


def _by_node(meshes: Sequence[Mesh], owner: IntArray) -> list[Proposal]:
    groups: dict[str, list[int]] = {}
    for index, mesh in enumerate(meshes):
        groups.setdefault(mesh.source_path or mesh.name, []).append(index)
    if len(groups) < 2:
        return []
    return [
        Proposal(np.isin(owner, members), "hierarchy", (meshes[members[0]].name, path.rpartition("/")[2]), path)
        for path, members in groups.items()
    ]


def _by_material(meshes: Sequence[Mesh], materials: Sequence[Material], owner: IntArray) -> list[Proposal]:
    used = sorted({m.material for m in meshes if m.material is not None})
    if len(used) < 2:
        return []
    groups = [(k, [i for i, m in enumerate(meshes) if m.material == k]) for k in used]
    return [Proposal(np.isin(owner, members), "material", (materials[k].name,)) for k, members in groups]


def _by_component(surface: FaceGeometry) -> list[Proposal]:
    """Connected pieces, unless the surface falls into crumbs."""
    proper = np.flatnonzero(~repeats_point(surface.triangles))
    count, label = face_components(edges_of(surface.triangles[proper]))
    share = np.bincount(label, surface.area[proper], count) / max(surface.area.sum(), np.finfo(float).tiny)
    large = np.flatnonzero(share > LEAST_SHARE)
    if not 2 <= len(large) <= MOST_COMPONENTS:
        return []
    masks = np.zeros((len(large), len(surface.triangles)), dtype=bool)
    for row, piece in enumerate(large):
        masks[row, proper[label == piece]] = True
    return [Proposal(mask, "component") for mask in masks]


def _role_of_piece(surface: FaceGeometry, faces: BoolArray) -> str:
    """`cover` for a piece of its own at the upper end of a thing, in the middle and narrower than the rest; else ""."""
    if not faces.any():
        return ""
    low, high = surface.box(faces)
    middle, size = 0.5 * (low + high) - surface.low - 0.5 * surface.extent, surface.extent
    upper = (low - surface.low)[2] > 0.7 * size[2] and (high - surface.low)[2] > 0.97 * size[2]
    central = (np.abs(middle)[:2] < 0.1 * size[:2]).all()
    return "cover" if upper and central and ((high - low)[:2] < 0.9 * size[:2]).all() else ""
