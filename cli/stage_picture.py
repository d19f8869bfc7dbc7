"""A picture of a written stage, drawn in a child process from what the stage holds."""

from __future__ import annotations

import tempfile
from pathlib import Path

from assetkit.readers.common.images import load_texture
from jobs.cell import Limits
from jobs.warm import run_module
from render.camera import CameraView
from render.request import RenderRequest
from schemas.files import array_files
from usdio.read.asset import read_stage

_LIMITS = Limits(seconds=120.0, memory_mb=6144)


def stage_picture(stage: Path, view: CameraView, size_px: int) -> bytes:
    """PNG of a stage that we wrote, `size_px` wide and high.

    Raises RuntimeError when the renderer fails: a broken environment, not a bad scene.
    """
    outcome = read_stage(stage, stage.parent, load_texture=load_texture, mechanism=False)
    assert outcome.value is not None, "our own stage can be read"
    with tempfile.TemporaryDirectory(prefix="mana") as place:
        request = Path(place) / "request.npz"
        asked = RenderRequest(model=outcome.value, shapes=(), out_dir=place, size_px=size_px, views=(view,))
        array_files.save(asked, RenderRequest, request)
        result = run_module("render", ["previews", str(request)], _LIMITS)
        if result.status != "ok":
            raise RuntimeError(f"renderer {result.status}: {result.output[-1500:]}")
        return (Path(place) / f"{view.name}.png").read_bytes()
