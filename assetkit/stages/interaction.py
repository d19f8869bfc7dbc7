"""Stage 5, interaction: the parts the source itself names, and anchors as geometry proposes them; asset frame."""

from __future__ import annotations

import numpy as np

from assetkit.anchors import propose_anchors
from assetkit.stage import Canonical, Draft, Interaction, Stage, Tools, need
from geom.cavity import find_cavities
from geom.surface_distance import triangle_areas
from schemas.asset import vec3
from schemas.evidence import Evidence, default, measured
from schemas.model import Mesh
from schemas.outcome import Outcome
from schemas.parts import UNLABELLED, Part, part_faces
from usdio.write_meshes import mesh_prim_names


class ProposeParts(Stage):
    """Takes the source hierarchy at its word: one part per named mesh group. Anchors wait for acceptance."""

    name = "interaction"
    version = 4
    result = Interaction

    def run(self, draft: Draft, tools: Tools) -> Outcome[Interaction]:
        """Parts with bounding boxes in metres, none when the source has one unnamed mesh; proposed anchors."""
        canonical: Canonical = need(draft.canonicalize, "canonicalize")
        groups: dict[str, dict[str, Mesh]] = {}
        for prim, mesh in zip(mesh_prim_names(draft.model), canonical.meshes, strict=True):
            groups.setdefault(mesh.source_path or mesh.name, {})[prim] = mesh
        found = sorted(groups.items()) if len(groups) > 1 else []
        parts = [_part(f"part_{i}", path, meshes) for i, (path, meshes) in enumerate(found)]
        cavities = find_cavities(canonical.solid)
        return Outcome(Interaction(tuple(parts), propose_anchors(canonical.solid, cavities), cavities))


def _part(part_id: str, path: str, meshes: dict[str, Mesh]) -> Evidence[Part]:
    points = np.concatenate([m.points for m in meshes.values()])
    part = Part(
        part_id=part_id,
        label=default(UNLABELLED),
        name=next(iter(meshes.values())).name or part_id,
        sources=("hierarchy",),
        source_path=path,
        faces=tuple(part_faces(prim, np.arange(len(mesh.triangles))) for prim, mesh in meshes.items()),
        triangles=sum(len(m.triangles) for m in meshes.values()),
        area_m2=sum(float(triangle_areas(m.points[m.triangles]).sum()) for m in meshes.values()),
        low_m=vec3(points.min(axis=0)),
        high_m=vec3(points.max(axis=0)),
    )
    return measured(part, "meshes grouped by source hierarchy", confidence=0.5)
