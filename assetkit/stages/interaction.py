"""Stage 5, interaction: the parts the source itself names, and anchors as geometry proposes them; asset frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from assetkit.anchors import propose_anchors
from assetkit.stage import Canonical, Draft, Interaction, Stage, Tools, need
from geom.cavity import find_cavities
from schemas.evidence import Evidence, measured
from schemas.model import Mesh
from schemas.outcome import Outcome


class ProposeParts(Stage):
    """Takes the source hierarchy at its word: one part per named mesh group. Anchors wait for acceptance."""

    name = "interaction"
    version = 3
    result = Interaction

    def run(self, draft: Draft, tools: Tools) -> Outcome[Interaction]:
        """Parts with bounding boxes in metres, none when the source has one unnamed mesh; proposed anchors."""
        canonical: Canonical = need(draft.canonicalize, "canonicalize")
        groups: dict[str, list[Mesh]] = {}
        for mesh in canonical.meshes:
            groups.setdefault(mesh.source_path or mesh.name, []).append(mesh)
        parts = [_part(path, meshes) for path, meshes in sorted(groups.items())] if len(groups) > 1 else []
        cavities = find_cavities(canonical.solid)
        return Outcome(Interaction(tuple(parts), propose_anchors(canonical.solid, cavities), cavities))


def _part(path: str, meshes: list[Mesh]) -> Evidence[dict[str, Any]]:
    points = np.concatenate([m.points for m in meshes])
    value = {
        "name": meshes[0].name,
        "source_path": path,
        "low_m": points.min(axis=0).tolist(),
        "high_m": points.max(axis=0).tolist(),
        "triangles": sum(len(m.triangles) for m in meshes),
    }
    return measured(value, "meshes grouped by source hierarchy", confidence=0.5)
