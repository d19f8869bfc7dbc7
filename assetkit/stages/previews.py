"""Pictures of the asset, made in a cell of their own: graphics drivers crash, assets must not go with them."""

from __future__ import annotations

import sys

from assetkit.stage import Draft, Previews, Tools, need
from jobs.cell import Limits, run_cell
from render.request import RenderRequest
from schemas import arrays
from schemas.diagnostics import Diagnostic
from schemas.outcome import Outcome

LIMITS = Limits(seconds=120.0, memory_mb=6144)


class RenderPreviews:
    """Four standard views, the collision overlay and a thumbnail."""

    name = "previews"
    version = 1
    result = Previews

    def accepts(self, draft: Draft) -> list[Diagnostic]:
        """Nothing forbids running."""
        return []

    def run(self, draft: Draft, tools: Tools) -> Outcome[Previews]:
        """PNG bytes by name. Raises RuntimeError when the renderer fails: a broken environment, not a bad asset."""
        folder = tools.work_dir / "render"
        folder.mkdir(parents=True, exist_ok=True)
        shapes = need(draft.physics, "physics").shapes
        request = folder / "request.npz"
        arrays.save(RenderRequest(model=draft.model, shapes=shapes, out_dir=str(folder)), RenderRequest, request)
        result = run_cell([sys.executable, "-m", "render", str(request)], LIMITS)
        if result.status != "ok":
            raise RuntimeError(f"renderer {result.status}: {result.output[-1500:]}")
        return Outcome(Previews({p.stem: p.read_bytes() for p in sorted(folder.glob("*.png"))}))
