"""`mana assets`: ingest files, look at the result."""

from __future__ import annotations

import json
import shutil
import sys
from functools import partial
from pathlib import Path
from typing import Annotated, cast, get_args

import typer
from pydantic import ValidationError
from rich.markup import escape

from assetkit.annotate.exchange import worst_seconds
from assetkit.batch.item_cells import default_jobs
from assetkit.batch.report_file import REPORT
from assetkit.batch.run_batch import ingest
from assetkit.batch.suite_rows import withdrawn_roles
from assetkit.batch.watch import SETTLE_S
from assetkit.options import AppearanceGenerator, Endpoint, Options, SegmenterCommand, UnitName, UpAxisName
from assetkit.package.record import RECORD, read_record
from cli import text
from cli.assets.accept import accept_command, show_exercised, show_suites
from cli.assets.doctor import doctor_command
from cli.assets.export import export_command
from cli.assets.gc import gc_command
from cli.assets.generate import generate_command
from cli.assets.listing import duplicates_command, list_command, stats_command
from cli.assets.program import program_stated
from cli.assets.progress import shown_progress
from cli.assets.publish import publish_command
from cli.assets.render import render_command
from cli.assets.review import review_command
from cli.assets.search import search_command
from cli.assets.synthesize import synthesize_command
from cli.assets.watch import watch_sources
from cli.engines import SIMULATOR
from cli.findings import show_findings
from cli.placement import Scheduler, placement_of
from jobs.cell import Limits
from schemas.acceptance import SuiteSection
from schemas.asset import Role
from schemas.diagnostics import Diagnostic, Severity
from schemas.exercised import exercised_ranges
from schemas.outcome import ItemOutcome

app = typer.Typer(help="Raw asset files in, accepted simulation packages out.", no_args_is_help=True)
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]


@app.command("ingest")
def ingest_command(
    sources: Annotated[list[Path], typer.Argument(help="Files, or folders that are walked.")],
    out: Annotated[Path, typer.Option("--out", help="Where packages, report and catalog go.")],
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Assets at a time.")] = default_jobs(),
    scheduler: Scheduler = None,
    root: Annotated[Path | None, typer.Option("--root", help="Folder that references may not leave.")] = None,
    role: Annotated[str | None, typer.Option(help="Declared role, e.g. manipulated or receptacle.")] = None,
    category: Annotated[str | None, typer.Option(help="Declared category, e.g. mug.")] = None,
    require_category: Annotated[
        bool, typer.Option("--require-category", help="Send objects of unknown category to review.")
    ] = False,
    units: Annotated[str, typer.Option(help="mm, cm, m, in or auto.")] = "auto",
    up_axis: Annotated[str, typer.Option("--up-axis", help="x, y, z or auto.")] = "auto",
    license_: Annotated[str | None, typer.Option("--license", help="Licence, e.g. CC-BY-4.0.")] = None,
    author: Annotated[str | None, typer.Option(help="Author of the source assets.")] = None,
    shell_thickness: Annotated[
        float | None, typer.Option("--shell-thickness", help="Wall thickness of open surfaces in millimetres.")
    ] = None,
    max_texture: Annotated[
        int | None, typer.Option("--max-texture", min=16, help="Pixels a side above which textures are made smaller.")
    ] = None,
    retopo: Annotated[
        int | None, typer.Option("--retopo", min=64, help="Triangles of a light mesh with baked maps; none by default.")
    ] = None,
    recover_appearance: Annotated[
        bool,
        typer.Option(
            "--recover-appearance", help="Plausible materials on surfaces that state none; marked as inferred."
        ),
    ] = False,
    appearance_generator: Annotated[
        str | None, typer.Option(help="A program of yours, or an http address, that proposes such materials.")
    ] = None,
    generator_timeout: Annotated[float, typer.Option(help="Seconds it may take for one object.")] = 60.0,
    annotator_url: Annotated[
        str | None,
        typer.Option(help="Base address of a model that is shown the pictures, e.g. https://api.openai.com/v1."),
    ] = None,
    annotator_model: Annotated[
        str | None, typer.Option(help="Its name. Its key is read from MANA_ANNOTATOR_KEY.")
    ] = None,
    annotator_kind: Annotated[str, typer.Option(help="openai (and compatible) or gemini.")] = "openai",
    annotator_timeout: Annotated[float, typer.Option(help="Seconds one request may take; it is tried 3 times.")] = 40.0,
    annotator_price: Annotated[
        tuple[float, float] | None, typer.Option(help="USD per million input and output tokens.")
    ] = None,
    segmenter: Annotated[
        str | None,
        typer.Option(help="A program of yours that proposes parts, as one would type it; docs/how-to/segmenter.md."),
    ] = None,
    segmenter_timeout: Annotated[float, typer.Option(help="Seconds it may take for one object.")] = 60.0,
    timeout: Annotated[float, typer.Option(help="Seconds one asset may take.")] = 300.0,
    memory: Annotated[int, typer.Option(help="Address space of one worker in MiB.")] = 8192,
    resume: Annotated[
        bool, typer.Option("--resume", help="Also keep crashed and timed-out items as they are.")
    ] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Make every item anew.")] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Print every item that is not accepted with all its findings.")
    ] = False,
    watch: Annotated[
        bool, typer.Option("--watch", help="Stay, and take up new and changed files as they come, until Ctrl-C.")
    ] = False,
    settle: Annotated[
        float, typer.Option(help="With --watch: seconds a file must have stayed the same before it is read.")
    ] = SETTLE_S,
    as_json: AsJson = False,
) -> None:
    """Take files through every stage and release a package for each object.

    Unchanged sources are not made again, so an interrupted run simply continues. Exit code 1 when an asset was
    rejected, 2 when the command could not run. One ingest at a time writes into an output folder: a second one ends at
    once with exit code 2 and names the process that is at work; a killed one blocks nobody.

    With --watch each item is printed when it is finished, with --json as a line of JSON, and items that fail stop
    nothing. Between passes the folder is free for other commands. Ctrl-C while it waits is exit code 0.

    Examples: `mana assets ingest scans/ extra/mug.glb --out library --jobs 4 --license CC-BY-4.0`,
    `mana assets ingest inbox --watch --out library`
    """
    if units not in get_args(UnitName):
        raise typer.BadParameter(f"must be one of {', '.join(get_args(UnitName))}", param_hint="--units")
    if up_axis not in get_args(UpAxisName):
        raise typer.BadParameter(f"must be one of {', '.join(get_args(UpAxisName))}", param_hint="--up-axis")
    if shell_thickness is not None and not shell_thickness > 0.0:
        raise typer.BadParameter("must be above zero", param_hint="--shell-thickness")
    if role is not None and role not in get_args(Role):
        raise typer.BadParameter(f"must be one of {', '.join(get_args(Role))}", param_hint="--role")
    endpoint = None
    if annotator_url is not None or annotator_model is not None:
        endpoint = endpoint_stated(annotator_url, annotator_model, annotator_kind, annotator_timeout, annotator_price)
        if (longest := worst_seconds(annotator_timeout)) >= timeout:
            said = f"must exceed the {longest:g} s that asking the annotator may take"
            raise typer.BadParameter(said, param_hint="--timeout")
    options = Options(
        units=cast(UnitName, units),
        up_axis=cast(UpAxisName, up_axis),
        role=role,
        category=category,
        require_category=require_category,
        endpoint=endpoint,
        recover_appearance=recover_appearance or appearance_generator is not None,
        generator=None
        if appearance_generator is None
        else generator_stated(appearance_generator, generator_timeout, timeout),
        segmenter=None if segmenter is None else segmenter_stated(segmenter, segmenter_timeout, timeout),
        license=license_,
        author=author,
        shell_thickness_m=None if shell_thickness is None else shell_thickness / 1000.0,
        max_texture=max_texture,
        retopo=retopo,
    )
    run = partial(
        ingest,
        sources,
        out,
        engine=SIMULATOR,
        options=options,
        root=root,
        placement=placement_of(jobs, scheduler),
        limits=Limits(timeout, memory),
        resume=resume,
        fresh=fresh,
    )
    if watch:
        watch_sources(sources, out, run, settle, as_json=as_json)
        return
    with shown_progress(quiet=as_json) as progress:
        report = run(progress=progress)
    if as_json:
        with (out / REPORT).open() as written:
            shutil.copyfileobj(written, sys.stdout)
    else:
        text.show_summary(report, verbose=verbose)
        text.console.print(f"report: {escape(str(out / 'report.html'))}", soft_wrap=True)
    if report.interrupted:
        if not as_json:
            text.console.print(f"interrupted after {report.totals['items']:.0f} items; the same command continues")
        raise typer.Exit(2)
    raise typer.Exit(1 if report.totals[ItemOutcome.REJECTED.value] else 0)


def endpoint_stated(
    url: str | None, model: str | None, kind: str, seconds: float, usd_per_million: tuple[float, float] | None
) -> Endpoint:
    """The endpoint that the `--annotator-*` flags name. Raises typer.BadParameter for an unusable one."""
    stated = {"kind": kind, "url": url, "model": model, "seconds": seconds, "usd_per_million": usd_per_million}
    try:
        return Endpoint.model_validate(stated)
    except ValidationError as error:
        first = error.errors()[0]
        flag = {"seconds": "timeout", "usd_per_million": "price"}.get(str(first["loc"][0]), first["loc"][0])
        raise typer.BadParameter(first["msg"], param_hint=f"--annotator-{flag}") from None


def segmenter_stated(command: str, seconds: float, timeout: float) -> SegmenterCommand:
    """The program that `--segmenter` names. Raises typer.BadParameter for what cannot run or may outlive its asset."""
    program = program_stated(command, "--segmenter")
    if not 0.0 < seconds < timeout:
        raise typer.BadParameter("must be above zero and below --timeout", param_hint="--segmenter-timeout")
    return SegmenterCommand(command=program.command, seconds=seconds, digest=program.digest)


def generator_stated(text: str, seconds: float, timeout: float) -> AppearanceGenerator:
    """The generator that `--appearance-generator` names. Raises typer.BadParameter for what cannot be used."""
    remote = text.startswith(("http://", "https://"))
    if not 0.0 < seconds <= 600.0 or (worst_seconds(seconds) if remote else seconds) >= timeout:
        raise typer.BadParameter("must be above zero and end before --timeout", param_hint="--generator-timeout")
    if remote:
        try:
            return AppearanceGenerator(url=Endpoint(url=text, model="generator").url, seconds=seconds)
        except ValidationError as error:
            raise typer.BadParameter(error.errors()[0]["msg"], param_hint="--appearance-generator") from None
    program = program_stated(text, "--appearance-generator")
    return AppearanceGenerator(command=program.command, seconds=seconds, digest=program.digest)


app.command("accept")(accept_command)
app.command("doctor")(doctor_command)
app.command("export")(export_command)
app.command("gc")(gc_command)
app.command("list")(list_command)
app.command("duplicates")(duplicates_command)
app.command("publish")(publish_command)
app.command("stats")(stats_command)
app.command("generate")(generate_command)
app.command("synthesize")(synthesize_command)
app.command("search")(search_command)
app.command("review")(review_command)
app.command("render")(render_command)


@app.command("show")
def show_command(
    package: Annotated[Path, typer.Argument(help="A package folder.", exists=True)], as_json: AsJson = False
) -> None:
    """Show what is known about one package, how sure it is, and which suites of acceptance hold within which margins.

    Example: `mana assets show library/mug`
    """
    record = json.loads((package / RECORD).read_text())
    if as_json:
        print(json.dumps(record, indent=1))
        return
    text.console.print(f"[bold]{record['asset_id']}[/bold]  {record['outcome']}")
    text.show_rows(_evidence_rows(record), {"what": "what", "value": "value", "source": "source", "sure": "sure"})
    suites = record["acceptance"].get("suites", ())  # records of earlier versions have none
    if suites:
        text.console.print("acceptance by suites")
        sections = [SuiteSection.model_validate(suite) for suite in suites]
        show_suites(sections)
        valid = read_record(package)  # None for one of an earlier version, which is shown as far as it goes
        show_exercised(None if valid is None else exercised_ranges(valid))
    for role in withdrawn_roles([Diagnostic.model_validate(each) for each in record["diagnostics"]]):
        text.console.print(f"  {role.headline} ({'; '.join(role.figures)})", soft_wrap=True, markup=False)


@app.command("validate")
def validate_command(
    path: Annotated[Path, typer.Argument(help="A USD file, a folder, a package or a library.", exists=True)],
    gate_only: Annotated[bool, typer.Option("--gate-only", help="Skip SimReady and UsdValidation.")] = False,
    timeout: Annotated[float, typer.Option(help="Seconds one file may take.")] = 120.0,
    as_json: AsJson = False,
) -> None:
    """Judge any USD asset: SimReady Robotics-Prop 4.0.0, OpenUSD's validators and Mana's plausibility gate.

    Errors are wrong in any file, or in a package that claims to be SimReady. Warnings are suspicious. Remarks say what
    keeps a file of somebody else from being such a package. Every finding names its prim; `docs/reference/gate.md` has
    all rules with their bounds. Exit code 1 when there is an error, 2 when nothing could be judged.

    Examples: `mana assets validate library`, `mana assets validate robot.usd --gate-only --json`
    """
    from assetkit.library.validate import main_usd_files, validate_files  # Loads USD, which most commands do not need.

    files = main_usd_files(path)
    if not files:
        raise FileNotFoundError(f"no USD file in {path}")
    results: dict[str, list[dict]] = {}
    failed = False
    for file, found in validate_files(files, external=not gate_only, limits=Limits(seconds=timeout)):
        failed = failed or any(d.severity is Severity.ERROR for d in found)
        results[str(file)] = [d.model_dump(mode="json") for d in found]
        if not as_json:
            show_findings(file, found)
    if as_json:
        print(json.dumps(results, indent=1))
    raise typer.Exit(1 if failed else 0)


# Directions of a record with the axes in which they are given.
_FRAMES = {"upright": "upright, in axes of the source", "front": "front, in axes of the asset"}


def _evidence_rows(record: dict) -> list[dict[str, object]]:
    """The headline values of a record, one row each."""
    rows: list[dict[str, object]] = []
    for section in ("geometry", "appearance", "semantics", "physics", "source"):
        for key, value in record.get(section, {}).items():
            if isinstance(value, dict) and "confidence" in value:
                sure = f"{100 * value['confidence']:.0f} %"
                source = f"{value['source']}: {value['method']}"
                rows.append(
                    {"what": _FRAMES.get(key, key), "value": _short(value["value"]), "source": source, "sure": sure}
                )
    looks = [_material_row(material) for material in record.get("appearance", {}).get("render_materials", ())]
    return rows + looks + [_joint_row(use) for use in record.get("joint_uses", ())]


def _material_row(material: dict) -> dict[str, object]:
    """The optics of a render material, its shaders, and the share of its values that the source states."""
    values = material["values"].values()
    stated = sum(value["source"] == "declared" for value in values)
    return {
        "what": f"material {material['name']}",
        "value": f"{material['optics']}: {', '.join(material['shaders']) or 'not used'}",
        "source": f"{stated} of {len(values)} values are declared",
        "sure": "",
    }


def _joint_row(use: dict) -> dict[str, object]:
    """What a joint of an articulated object is for: its group, and from where to where it opens."""
    group, ends = use["group"], f"{_short(use['closed']['value'])} to {_short(use['open']['value'])}"
    return {
        "what": f"joint {use['joint']}",
        "value": f"{group['value']}, {use['task']} from {ends}",
        "source": f"{group['source']}: {group['method']}",
        "sure": f"{100 * group['confidence']:.0f} %",
    }


def _short(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_short(v) for v in value) + "]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
