"""Stage 5, interaction: the parts the source itself names, with their place in the asset frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from assetkit.stage import Draft, Interaction, Stage, Tools, need
from schemas.evidence import Evidence, measured
from schemas.model import Mesh
from schemas.outcome import Outcome


class ProposeParts(Stage):
    """Takes the source hierarchy at its word: one part per named mesh group."""

    name = "interaction"
    version = 1
    result = Interaction

    def run(self, draft: Draft, tools: Tools) -> Outcome[Interaction]:
        """Parts with bounding boxes in metres, asset frame; empty when the source has one unnamed mesh."""
        groups: dict[str, list[Mesh]] = {}
        for mesh in need(draft.canonicalize, "canonicalize").meshes:
            groups.setdefault(mesh.source_path or mesh.name, []).append(mesh)
        if len(groups) < 2:
            return Outcome(Interaction(()))
        return Outcome(Interaction(tuple(_part(path, meshes) for path, meshes in sorted(groups.items()))))


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
