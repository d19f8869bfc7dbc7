"""Stage 2, canonicalize: one object in metres, z up, origin at the bottom centre; observed and repaired."""

from __future__ import annotations

from assetkit.geometry.canonical_model import canonicalize
from assetkit.stage import Canonical, Draft, Retopology, Stage, Tools
from schemas.outcome import Outcome


class Canonicalize(Stage):
    """Brings an object into its metric frame and mends what is broken; every edit has figures before and after."""

    name = "canonicalize"
    version = 11
    result = Canonical
    reads = (Retopology,)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Canonical]:
        """Canonical meshes, the physical surface and the geometry section."""
        return canonicalize(draft.item, draft.source_name, tools.options, draft.frame)
