"""Parts of an object for its record, from canonical meshes (metres), materials, category and an optional segmenter."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.parts.proposals import Segmenter, SegmenterResult, join_meshes, propose
from assetkit.parts.reconcile import PartCandidate, reconcile
from assetkit.taxonomy.tables import categories
from geom.features.cavities import Cavity
from geom.features.regions import FaceGeometry
from schemas.appearance.material import Material
from schemas.asset import vec3
from schemas.evidence import Evidence, default, inferred, measured
from schemas.model import Mesh
from schemas.parts import UNLABELLED, Part, part_faces

# Confidence that a region is a part: stated by the source, clues agree, one clue alone.
_STATED, _AGREED, _ALONE = 0.8, 0.7, 0.5


@dataclass(frozen=True)
class PartsResult:
    """Parts, the one with most surface first; `segmenter_problem` explains a missing or partial answer."""

    parts: tuple[Evidence[Part], ...]
    segmenter_problem: str = ""


def find_parts(
    meshes: Mapping[str, Mesh],
    materials: Sequence[Material],
    category: Evidence[str],
    *,
    segmenter: Segmenter | None = None,
    cavities: Sequence[Cavity] = (),
) -> PartsResult:
    """Parts of canonical `meshes` by id, none when nothing but the whole was proposed.

    `category` may be unknown. No label has more confidence than the category whose vocabulary it is from. `cavities`
    are those of the solid.
    """
    shown = {mesh_id: mesh for mesh_id, mesh in meshes.items() if len(mesh.triangles)}
    known = categories().get(category.value)
    vocabulary, kind = (known.parts, known.id) if known else ((), "")
    if not shown:
        return PartsResult(())
    surface = join_meshes(list(shown.values()))
    if surface.area.sum() <= 0.0:
        return PartsResult(())
    openings = [c.direction for c in cavities if not c.through]
    learned = segmenter.segment(surface, kind, vocabulary) if segmenter is not None else SegmenterResult()
    proposals = propose(surface, list(shown.values()), materials, kind, vocabulary, learned.proposals, openings)
    reconciled = reconcile(surface, proposals, kind, vocabulary)
    most = category.confidence if known else 1.0
    parts = [
        _part(surface, shown, piece, f"part_{i}", most, parent)
        for i, (piece, parent) in enumerate(zip(reconciled.pieces, reconciled.parents, strict=True))
    ]
    return PartsResult(tuple(parts), learned.problem)


def _part(
    surface: FaceGeometry, meshes: Mapping[str, Mesh], piece: PartCandidate, part_id: str, most: float, parent: int
) -> Evidence[Part]:
    label: Evidence[str] = default(UNLABELLED, piece.doubt or "no clue")
    if piece.label != UNLABELLED:
        clues = tuple(dict.fromkeys(v.clue for v in piece.votes))
        label = inferred(piece.label, "part names of the category", min(piece.confidence, most), inputs=clues)
    low, high = surface.box(piece.faces)
    starts = np.cumsum([0, *(len(m.triangles) for m in meshes.values())])
    indices = [np.flatnonzero(piece.faces[a:b]) for a, b in itertools.pairwise(starts)]
    part = Part(
        part_id=part_id,
        label=label,
        may_be=piece.may_be,
        name=label.value if label.confidence else next((n for n in piece.names if n), part_id),
        sources=piece.sources,
        source_path=piece.path,
        faces=tuple(part_faces(mesh_id, k) for mesh_id, k in zip(meshes, indices, strict=True) if len(k)),
        triangles=int(piece.faces.sum()),
        area_m2=piece.area,
        low_m=vec3(low),
        high_m=vec3(high),
        parent=f"part_{parent}" if parent >= 0 else None,
        link=_link_of([m for m, k in zip(meshes.values(), indices, strict=True) if len(k)]),
    )
    confidence = _STATED if "hierarchy" in piece.sources else _AGREED if len(piece.sources) > 1 else _ALONE
    return measured(part, "regions proposed by " + ", ".join(piece.sources), confidence=confidence)


def _link_of(meshes: Sequence[Mesh]) -> str | None:
    """The link that all meshes belong to; None where they are of several, or of a rigid object."""
    links = {mesh.link for mesh in meshes}
    return next(iter(links)) or None if len(links) == 1 else None
