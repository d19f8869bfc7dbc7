"""`mana assets generate`: make a parametric mechanism or prop, with exact truth, and take it through the pipeline."""

from __future__ import annotations

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.markup import escape

from assetkit.batch.item_cells import default_jobs
from assetkit.batch.report_file import FinishedBatch, read_report
from assetkit.batch.run_batch import ingest
from assetkit.generate.parameters import Parameter, ParameterError, nearest, parameters_of, read_settings
from assetkit.generate.truth import TRUTH_FILE
from assetkit.sources.discover import slug
from cli import text
from cli.assets.progress import shown_progress
from cli.engines import SIMULATOR
from jobs.placement import Placement
from schemas.outcome import ItemOutcome

if TYPE_CHECKING:
    from assetkit.generate.generator import Generator

SOURCES = "sources"  # folder of the library that holds what was written for the pipeline


def generate_command(
    name: Annotated[str | None, typer.Argument(help="What to make; --list shows all names.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="key=value, in the unit of the key. May be repeated.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Library for packages; sources go to its folder sources/.")] = Path(
        "generated"
    ),
    called: Annotated[
        str | None, typer.Option("--name", help="Name of the object instead of the generator's; before those of a set.")
    ] = None,
    source_only: Annotated[
        bool, typer.Option("--source-only", help="Write the sources with truth.json and stop there.")
    ] = False,
    listing: Annotated[
        bool, typer.Option("--list", help="List all generators; with NAME its parameters with unit and range.")
    ] = False,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Objects at a time.")] = default_jobs(),
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Make a mechanism or prop from parameters: a drawer unit, a microwave, a set of rings, ...

    A small program writes a source (URDF, or MJCF where a joint has a spring) with meshes, materials, masses, limits
    and damping, and beside it `truth.json`: axes, limits, masses, volumes of insides and clearances as they were built.
    Then `mana assets ingest` runs on it, so the package has evidence like any other. A set (rings with their stand,
    discs, blocks, plug and socket) becomes one package per object.

    The same parameters give the same bytes. Lengths are in metres, angles in radians. Exit code 1 when an object was
    rejected, 2 for a name, a key or a value that is not allowed.

    Examples: `mana assets generate --list`, `mana assets generate drawer_unit --list`,
    `mana assets generate drawer_unit --set levels=4 --set width_m=0.5 --out library --name tall_drawer_unit`
    """
    from assetkit.generate.write import write_set  # Loads geometry libraries, which most commands do not need.

    if name is None:
        if not listing:
            raise typer.BadParameter("is needed; --list shows all", param_hint="NAME")
        _show_generators(as_json)
        return
    generator = _generator(name)
    if listing:
        _show_parameters(generator, as_json)
        return
    try:
        values = read_settings(generator.parameters, settings or ())
    except ParameterError as error:
        raise typer.BadParameter(str(error), param_hint="--set") from None
    folder = emptied(out / SOURCES / slug(called or generator.name), TRUTH_FILE)
    files = write_set(generator, values, folder, None if called is None else slug(called))
    if source_only:
        _show_sources(files, folder, as_json)
        return
    _ingest(files, folder, out, jobs, as_json)


def _ingest(files: Sequence[Path], folder: Path, out: Path, jobs: int, as_json: bool) -> None:
    """Run the pipeline on the sources; exits with 1 when one was rejected, 2 when it was interrupted."""
    with shown_progress(quiet=as_json) as progress:
        report = ingest(list(files), out, engine=SIMULATOR, placement=Placement(jobs), progress=progress)
    finish(report, out, ("truth", folder / TRUTH_FILE), as_json=as_json)


def finish(report: FinishedBatch, out: Path, made: tuple[str, Path], *, as_json: bool) -> NoReturn:
    """Print what became of sources that a command made, and the file on them by its name; exits with its code."""
    name, file = made
    if as_json:
        print(json.dumps({name: str(file), "report": read_report(out).model_dump(mode="json")}, indent=1))
    else:
        text.show_summary(report)
        text.console.print(f"{name}: {escape(str(file))}", soft_wrap=True)
        text.console.print(f"report: {escape(str(out / 'report.html'))}", soft_wrap=True)
    if report.interrupted:
        raise typer.Exit(2)
    raise typer.Exit(1 if report.totals[ItemOutcome.REJECTED.value] else 0)


def _generator(name: str) -> Generator[Any]:
    from assetkit.generate.table import GENERATORS

    if name not in GENERATORS:
        hint = nearest(name, list(GENERATORS))
        raise typer.BadParameter(f"there is no generator '{name}'; {hint}", param_hint="NAME")
    return GENERATORS[name]


def emptied(folder: Path, mark: str) -> Path:
    """The folder of an earlier run, emptied; raises typer.BadParameter for a folder without the file `mark`."""
    if folder.exists():
        if not (folder / mark).is_file():
            raise typer.BadParameter(f"{folder} exists and holds no {mark}; choose another", param_hint="--out")
        shutil.rmtree(folder)
    return folder


def _show_generators(as_json: bool) -> None:
    from assetkit.generate.table import GENERATORS

    if as_json:
        described = [{"name": g.name, "title": g.title, "parameters": _rows(g)} for g in GENERATORS.values()]
        print(json.dumps(described, indent=1))
        return
    rows: list[dict[str, object]] = [
        {"name": g.name, "title": g.title, "keys": ", ".join(p.name for p in parameters_of(g.parameters))}
        for g in GENERATORS.values()
    ]
    text.show_rows(rows, {"name": "name", "title": "what it makes", "keys": "keys of --set"})


def _show_parameters(generator: Generator[Any], as_json: bool) -> None:
    if as_json:
        print(json.dumps(_rows(generator), indent=1))
        return
    text.console.print(f"[bold]{generator.name}[/bold]: {escape(generator.title)}")
    rows = [
        {"key": p.name, "default": p.default, "allowed": p.allowed, "about": p.about}
        for p in parameters_of(generator.parameters)
    ]
    text.show_rows(rows, {"key": "key", "default": "default", "allowed": "allowed", "about": "meaning"})


def _rows(generator: Generator[Any]) -> list[dict[str, object]]:
    return [_row(parameter) for parameter in parameters_of(generator.parameters)]


def _row(p: Parameter) -> dict[str, object]:
    row: dict[str, object] = {"name": p.name, "default": p.default, "about": p.about}
    return row | ({"choices": list(p.choices)} if p.choices else {"low": p.low, "high": p.high, "unit": p.unit})


def _show_sources(files: Sequence[Path], folder: Path, as_json: bool) -> None:
    if as_json:
        print(json.dumps({"truth": str(folder / TRUTH_FILE), "sources": [str(file) for file in files]}, indent=1))
        return
    for file in (*files, folder / TRUTH_FILE):
        text.console.print(escape(str(file)), soft_wrap=True)
