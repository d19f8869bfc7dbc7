"""Previews, the stage after physics: PNG pictures of the asset, its colliders, parts and joints."""

from __future__ import annotations

from assetkit.package.preview_images import render_previews
from assetkit.stage import Appearance, Canonical, Draft, Interaction, Physics, Previews, Recovery, Stage, Tools
from schemas.outcome import Outcome


class RenderPreviews(Stage):
    """Four standard views, the collision overlay, the parts, the strip of a mechanism and a thumbnail."""

    name = "previews"
    version = 3
    result = Previews
    reads = (Canonical, Appearance, Interaction, Recovery, Physics)

    def run(self, draft: Draft, tools: Tools) -> Outcome[Previews]:
        """PNG bytes by name."""
        shapes, parts = draft[Physics].shapes, draft[Interaction].parts
        images = render_previews(draft.model, shapes, tools.work_dir, [p.value for p in parts], joints=True)
        return Outcome(Previews(images))
