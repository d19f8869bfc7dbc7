"""Stage 3, appearance: materials within their ranges, textures within their budget; every change is reported."""

from __future__ import annotations

from assetkit.materials.normalize import normalize
from assetkit.stage import Appearance, Canonical, Draft, Retopology, Stage, Tools
from schemas.outcome import Outcome


class NormalizeAppearance(Stage):
    """Checks every material value against its range, and textures and their coordinates against the uses of them."""

    name = "appearance"
    version = 6
    result = Appearance
    reads = (Retopology, Canonical)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Appearance]:
        """Materials and textures as released, and a record of their values with the evidence."""
        return normalize(draft.model, draft[Canonical].meters_per_unit, tools.options.max_texture)
