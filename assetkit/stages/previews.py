"""Previews, the stage after physics: PNG pictures of the asset, its colliders and its parts."""

from __future__ import annotations

from assetkit.package.preview_images import render_previews
from assetkit.stage import Draft, Previews, Stage, Tools, need
from schemas.outcome import Outcome


class RenderPreviews(Stage):
    """Four standard views, the collision overlay, the parts and a thumbnail."""

    name = "previews"
    version = 2
    result = Previews

    def run(self, draft: Draft, tools: Tools) -> Outcome[Previews]:
        """PNG bytes by name."""
        shapes, parts = need(draft.physics, "physics").shapes, need(draft.interaction, "interaction").parts
        return Outcome(Previews(render_previews(draft.model, shapes, tools.work_dir, [p.value for p in parts])))
