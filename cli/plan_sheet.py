"""A contact sheet of sampled scenes, drawn from the USD layers that realise them."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw
from rich.progress import Progress

from assetkit.readers.images import load_texture
from cli.plan_realise import Layers
from jobs.cache import write_atomically
from jobs.cell import Limits
from jobs.warm import run_module
from render.camera import View
from render.request import RenderRequest
from runtime_plan import Plan, sample
from schemas import arrays
from usdio.read import read_stage

_TILE_PX, _GAP_PX = 320, 6
_VIEW = View("tile", -70.0, 40.0)
_LIMITS = Limits(seconds=120.0, memory_mb=6144)


def draw_sheet(plan: Plan, folder: Path, n: int, seed: int, out: Path, progress: Progress) -> Path:
    """Write `out`, a picture of the first n samples of a stream; `folder` has the plan's scenes and packages.

    The studio lights them alike, so that poses and materials can be compared; the drawn lighting is in the layers.
    Raises RuntimeError when the renderer fails.
    """
    drawn, layers = sample(plan, n, seed), Layers(plan, folder)
    across = int(n**0.5 + 0.999)
    down = -(-n // across)
    step = _TILE_PX + _GAP_PX
    sheet = Image.new("RGB", (across * step + _GAP_PX, down * step + _GAP_PX), "white")
    task = progress.add_task("drawing", total=n)
    for k in range(n):
        file = folder / f".sheet-{k}.usda"
        try:
            tile = _tile(layers.write(drawn, k, file))
        finally:
            file.unlink(missing_ok=True)
        ImageDraw.Draw(tile).text((6, 4), f"{k}", fill="black")
        sheet.paste(tile, (_GAP_PX + (k % across) * step, _GAP_PX + (k // across) * step))
        progress.update(task, advance=1)
    data = io.BytesIO()
    sheet.save(data, "PNG", optimize=True)
    write_atomically(out, data.getvalue())
    return out


def _tile(stage: Path) -> Image.Image:
    outcome = read_stage(stage, stage.parent, load_texture=load_texture)
    assert outcome.value is not None, "our own layer can be read"
    with tempfile.TemporaryDirectory(prefix="mana") as place:
        request = Path(place) / "request.npz"
        asked = RenderRequest(model=outcome.value, shapes=(), out_dir=place, size_px=_TILE_PX, views=(_VIEW,))
        arrays.save(asked, RenderRequest, request)
        result = run_module("render", [str(request)], _LIMITS)
        if result.status != "ok":
            raise RuntimeError(f"renderer {result.status}: {result.output[-1500:]}")
        with Image.open(Path(place) / f"{_VIEW.name}.png") as picture:
            return picture.convert("RGB")
