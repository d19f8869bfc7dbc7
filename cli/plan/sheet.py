"""A contact sheet of sampled scenes, drawn from the USD layers that realise them."""

from __future__ import annotations

import io
from pathlib import Path

from PIL import Image, ImageDraw
from rich.progress import Progress

from cli.plan.realise import Layers
from cli.stage_picture import stage_picture
from jobs.cache import write_atomically
from render.camera import CameraView
from runtime_plan import Plan, sample

_TILE_PX, _GAP_PX = 320, 6
_VIEW = CameraView("tile", -70.0, 40.0)


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
            picture = stage_picture(layers.write(drawn, k, file), _VIEW, _TILE_PX)
        finally:
            file.unlink(missing_ok=True)
        tile = Image.open(io.BytesIO(picture)).convert("RGB")
        ImageDraw.Draw(tile).text((6, 4), f"{k}", fill="black")
        sheet.paste(tile, (_GAP_PX + (k % across) * step, _GAP_PX + (k // across) * step))
        progress.update(task, advance=1)
    data = io.BytesIO()
    sheet.save(data, "PNG", optimize=True)
    write_atomically(out, data.getvalue())
    return out
