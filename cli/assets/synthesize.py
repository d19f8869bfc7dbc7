"""`mana assets synthesize`: a generative model of the user makes a mesh of text or a picture, the pipeline goes on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, cast, get_args

import typer

from assetkit.batch.run_batch import ingest
from assetkit.generate.synthesize import SYNTHESIS_FILE, SynthesisRequest, synthesize
from assetkit.options import Options, UnitName
from assetkit.sources.discover import slug
from cli.assets.generate import SOURCES, emptied, finish
from cli.assets.program import program_stated
from cli.assets.progress import shown_progress
from cli.engines import SIMULATOR
from jobs.cell import Limits
from jobs.placement import Placement

_IMAGES = (".png", ".jpg", ".jpeg", ".webp")


def synthesize_command(
    prompt: Annotated[str, typer.Argument(help="What to make, in words; with --image it may be empty.")] = "",
    model: Annotated[
        str, typer.Option("--model", help="Your program that runs a generative model; docs/how-to/retopology.md.")
    ] = "",
    image: Annotated[Path | None, typer.Option("--image", help="A picture of it (PNG, JPEG, WebP).")] = None,
    out: Annotated[Path, typer.Option("--out", help="Library for packages; sources go to its folder sources/.")] = Path(
        "synthesized"
    ),
    called: Annotated[str | None, typer.Option("--name", help="Name of the object; by default the prompt's.")] = None,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the model's random numbers.")] = 0,
    retopo: Annotated[
        int, typer.Option("--retopo", min=0, help="Triangles of the light mesh; 0 keeps the model's own.")
    ] = 5000,
    category: Annotated[str | None, typer.Option(help="Declared category, e.g. mug; it tells the size.")] = None,
    units: Annotated[str, typer.Option(help="Unit of the model's meshes: mm, cm, m, in or auto.")] = "auto",
    license_: Annotated[str | None, typer.Option("--license", help="Licence of what the model makes.")] = None,
    timeout: Annotated[float, typer.Option(help="Seconds the model may take, and again the pipeline.")] = 600.0,
    memory: Annotated[int, typer.Option(help="Address space of the model in MiB.")] = 65536,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Make an object of text or a picture by a generative model of yours, and take it through the pipeline.

    The model runs as a program in a process of its own; Mana holds none and sends nothing anywhere. Its mesh becomes a
    source like any other: a light mesh with baked maps (--retopo), repair, physics, acceptance. `synthesis.json` beside
    the source states prompt, seed, program and hashes; the record names the program as author. Exit code 1 when the
    model made nothing or the object was rejected, 2 for what is not allowed.

    Example: `mana assets synthesize "a red coffee mug" --model "python my_model.py" --out library`
    """
    if not prompt.strip() and image is None:
        raise typer.BadParameter("is needed, or --image", param_hint="PROMPT")
    if image is not None and (image.suffix.lower() not in _IMAGES or not image.is_file()):
        raise typer.BadParameter(f"must be a file that ends with {', '.join(_IMAGES)}", param_hint="--image")
    if 0 < retopo < 64:
        raise typer.BadParameter("must be 0 or at least 64", param_hint="--retopo")
    if units not in get_args(UnitName):
        raise typer.BadParameter(f"must be one of {', '.join(get_args(UnitName))}", param_hint="--units")
    program = program_stated(model, "--model")
    name = slug(called or prompt.strip() or (image.stem if image else ""))
    folder = emptied(out / SOURCES / name, SYNTHESIS_FILE)
    request = SynthesisRequest(prompt, image, seed)
    source = synthesize(program.command, program.digest, request, folder, name, Limits(timeout, memory))
    stated = json.loads((folder / SYNTHESIS_FILE).read_text(encoding="utf-8"))
    author = f"generative model '{stated['program']}'"
    options = Options(
        units=cast(UnitName, units), category=category, license=license_, author=author, retopo=retopo or None
    )
    with shown_progress(quiet=as_json) as progress:
        report = ingest(
            [source],
            out,
            engine=SIMULATOR,
            options=options,
            placement=Placement(1),
            limits=Limits(seconds=timeout),
            progress=progress,
        )
    finish(report, out, ("synthesis", folder / SYNTHESIS_FILE), as_json=as_json)
