"""Pictures of the asset, made in a cell of their own: graphics drivers crash, assets must not go with them."""

from __future__ import annotations

import tempfile
from pathlib import Path

from assetkit.stage import Draft, Previews, Stage, Tools, need
from jobs.cell import Limits
from jobs.warm import run_module
from render.drawn_grasp import DrawnGrasp
from render.request import RenderRequest
from schemas import arrays
from schemas.model import Model
from schemas.outcome import Outcome
from schemas.physics import CollisionShape

LIMITS = Limits(seconds=120.0, memory_mb=6144)


class RenderPreviews(Stage):
    """Four standard views, the collision overlay and a thumbnail."""

    name = "previews"
    version = 1
    result = Previews

    def run(self, draft: Draft, tools: Tools) -> Outcome[Previews]:
        """PNG bytes by name."""
        return Outcome(Previews(render(draft.model, need(draft.physics, "physics").shapes, tools.work_dir)))


def render(
    model: Model, shapes: tuple[CollisionShape, ...], work_dir: Path, grasps: tuple[DrawnGrasp, ...] = ()
) -> dict[str, bytes]:
    """PNG bytes by name, of a canonical model and its collision shapes; with `grasps` only a picture of those.

    Raises RuntimeError when the renderer fails: a broken environment, not a bad asset.
    """
    work_dir.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work_dir) as place:
        request = Path(place) / "request.npz"
        arrays.save(RenderRequest(model=model, shapes=shapes, out_dir=place, grasps=grasps), RenderRequest, request)
        result = run_module("render", [str(request)], LIMITS)
        if result.status != "ok":
            raise RuntimeError(f"renderer {result.status}: {result.output[-1500:]}")
        return {p.stem: p.read_bytes() for p in sorted(Path(place).glob("*.png"))}
