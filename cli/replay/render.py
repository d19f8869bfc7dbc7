"""`mana replay compose` and `mana replay render`: a variant as a stage, and as its recorded cameras see it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from cli import text
from jobs.cell import Limits
from jobs.json_cell import ONE_THREAD, ask
from jobs.schedule import run_all
from jobs.warm import warm_cells

_CELL, _LIMITS = "cli.replay.render_cell", Limits(seconds=12 * 3600.0, memory_mb=8192)

Folder = Annotated[Path, typer.Argument(help="Folder with the variant.json of one variant.", exists=True)]
Assets = Annotated[Path | None, typer.Option("--assets", help="Folder of packages; else those beside.", exists=True)]
Meshes = Annotated[Path | None, typer.Option("--meshes", help="Mesh files that models name.", exists=True)]


def compose_command(variant: Folder, assets: Assets = None, meshes: Meshes = None) -> None:
    """Write a variant as a USD stage: replay.usda over motion.usdc (recorded) and context.usda (put in, lights).

    Time codes are the recorded stamps in seconds. Packages are copied beside, so that the folder can be handed on.

    Example: `mana replay compose out/lift/variant_0001 --assets library/`
    """
    from replay.variant_stage import compose  # OpenUSD takes a second to load.

    file = compose(variant, assets, meshes)
    text.console.print(f"{file} written", markup=False)


def render_command(
    variant: Folder,
    out: Annotated[Path, typer.Option("--out", help="Where the pictures go.")],
    assets: Assets = None,
    meshes: Meshes = None,
    cameras: Annotated[str, typer.Option("--cameras", help="Names, with commas between; all by default.")] = "",
    every: Annotated[int, typer.Option("--every", min=1, help="Draw each k-th row of the recording.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Draw a variant as its recorded cameras see it: colour, depth and instances, a PNG for each row.

    Depth is in millimetres along the optical axis (16 bits, 0: nothing within 65 m); frames.json names stamps, poses,
    lenses and instances. Recorded bodies are drawn as their collision shapes, inserted ones as their packages.

    Example: `mana replay render out/lift/variant_0001 --out pictures/ --cameras agentview --every 10`
    """
    from cli.replay.frames import NoSuchCamera, draw_variant

    try:
        with warm_cells("render.frames", env=ONE_THREAD):  # VTK is loaded once for all cameras.
            figures = draw_variant(variant, out, assets, meshes, camera_names(cameras), every, quiet=as_json)
    except NoSuchCamera as error:
        raise typer.BadParameter(str(error)) from None
    if as_json:
        print(json.dumps(figures, indent=1))
    else:
        text.console.print(f"{figures['frames']} frames in {out}, {figures['frames_per_s']} a second", markup=False)


def camera_names(cameras: str) -> list[str]:
    """Names with commas between, as options give them."""
    return [word.strip() for word in cameras.split(",") if word.strip()]


def draw_variants(folders: Sequence[Path], given: dict[str, Any], jobs: int, quiet: bool) -> dict[Path, dict[str, Any]]:
    """What the cell of each variant answers: `frames`, or `refused` with a diagnostic; `pictures/` in its folder."""
    answers: dict[Path, dict[str, Any]] = {}
    with warm_cells(_CELL, env=ONE_THREAD), text.progress(quiet=quiet) as bar:
        task = bar.add_task("drawing", total=len(folders))
        for folder, answer in run_all(
            lambda one: ask(_CELL, {**given, "folder": str(one)}, _LIMITS, one.name, stopped="replay/stopped"),
            folders,
            jobs=jobs,
        ):
            answers[folder] = answer
            bar.advance(task)
    return {folder: answers[folder] for folder in folders}
