"""Stage 3, appearance: materials clamped to the ranges of UsdPreviewSurface; every change is reported."""

from __future__ import annotations

from assetkit.materials.normalize import normalize
from assetkit.stage import Appearance, Canonical, Draft, Stage, Tools
from schemas.outcome import Outcome


class NormalizeAppearance(Stage):
    """Checks every material value against its range and every texture use against the textures that exist."""

    name = "appearance"
    version = 3
    result = Appearance
    reads = (Canonical,)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Appearance]:
        """Clean materials, and a record of what has no counterpart in UsdPreviewSurface."""
        return normalize(draft.model)
