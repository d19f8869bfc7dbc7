"""`mana gap`: what a simulation is missing, named from recordings of the real thing."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from cli import text
from cli.engines import REPLAY_ENGINE
from cli.placement import Scheduler, placement_of
from jobs.cache import write_atomically
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.sim_gap.report import GapReport

if TYPE_CHECKING:
    from sim.effects.effect import Effect
    from simgap.recording.read import Measurement

app = typer.Typer(help="Compare a model with recordings and name what it is missing.", no_args_is_help=True)
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]
Folder = Annotated[Path, typer.Argument(help="A folder with measurement.yaml and trajectories/.", exists=True)]
_STATUS = {"effect_found": "green", "no_effect": "blue", "ambiguous": "yellow", "outside_model_class": "yellow"}


@app.command("find")
def find_command(
    measurements: Annotated[
        list[Path], typer.Argument(help="Folders with measurement.yaml and trajectories/.", exists=True)
    ],
    out: Annotated[Path, typer.Option("--out", help="Folder for the report, or for those of several; made if absent.")],
    jobs: Annotated[
        int, typer.Option("--jobs", min=1, help="Processes for one folder, or folders at a time; answers are the same.")
    ] = 1,
    scheduler: Scheduler = None,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="Skip what no verdict rests on: a baseline with all effects, roll-outs in the engine.",
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Say which effect the model lacks, how strong it is, how sure that is, and what it gains on unseen trials.

    Finding no effect, or two that cannot be distinguished, is an answer too; the page `report.html` explains it. The
    same command again gives the stored answer at once, or continues where it was interrupted. Of several folders each
    has its report in a folder of its name below --out. Exit code 1 when a folder cannot be used, 2 when interrupted or
    called wrongly.

    Examples: `mana gap find recordings/door --out door_gap`, `mana gap find recordings/* --out gaps --jobs 4`
    """
    if len(measurements) > 1 or scheduler is not None:
        from cli.gap.find_many import find_in_all  # Loads the search.

        find_in_all(measurements, out, placement_of(jobs, scheduler), quick=quick, as_json=as_json)
    [measurement] = measurements
    from simgap.run import search  # Loads engine and plotting.

    started = time.monotonic()
    value, findings = _read(measurement, as_json)
    with text.progress(quiet=as_json) as progress:
        task = progress.add_task("reading", total=None)

        def tick(words: str, done: int = 0, total: int | None = None) -> None:
            progress.update(task, description=words, completed=done, total=total)

        try:
            report = search(
                value, findings, out, engine=REPLAY_ENGINE, jobs=jobs, tick=tick, since=started, quick=quick
            )
        except KeyboardInterrupt:
            if not as_json:
                text.console.print("interrupted; the same command continues")
            raise typer.Exit(2) from None
    if as_json:
        print(report.model_dump_json(indent=1))
    else:
        _show(report)
        text.console.print(f"report: {escape(str(out / 'report.html'))}", soft_wrap=True)


@app.command("plan")
def plan_command(
    measurement: Folder,
    answer: Annotated[Path, typer.Argument(help="The folder that `mana gap find --out` wrote for it.", exists=True)],
    as_json: AsJson = False,
) -> None:
    """Say which recording to make next, so that effects in doubt can be distinguished.

    For each further recording that the same rig could make (smaller, slower, larger, faster or mirrored inputs, other
    releases, a known load, repeats) it works out what a rival would leave unexplained if the effect that was found is
    the true one, and whether that rejects the rival. The plan goes into `plan.json` beside the report.

    Example: `mana gap plan recordings/door door_gap`
    """
    from cli.gap.plan import plan  # Loads the search.

    value, _ = _read(measurement, as_json)
    found = plan(value, answer)
    if as_json:
        print(found.model_dump_json(indent=1))
        return
    text.console.print(escape(found.statement), soft_wrap=True)
    if found.recordings:
        rows: list[dict[str, object]] = [
            {"do": r.words, "left": f"{min(r.left):.3g}", "settles": "yes" if r.separates else "no"}
            for r in found.recordings
        ]
        text.show_rows(rows, {"do": "recording", "left": "loss left", "settles": "settles it"})
    text.console.print(f"plan: {escape(str(answer / 'plan.json'))}", soft_wrap=True)


@app.command("simulate")
def simulate_command(
    measurement: Folder,
    out: Annotated[Path, typer.Option("--out", help="Where trajectories and figures go.")],
    extension: Annotated[
        Path | None, typer.Option("--extension", help="An extension.json to put on top of the model.", exists=True)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Replay every trial with the declared model, and with an extension, and write both beside the readings.

    Of a mechanism PyBullet replays the first 3 s of the first trial too: what that engine does with the same numbers.

    Example: `mana gap simulate recordings/door --extension door_gap/extension.json --out door_replay`
    """
    from cli.gap.simulate import simulate

    value, _ = _read(measurement, as_json)
    summary = simulate(value, extension, out)
    if as_json:
        print(json.dumps(summary, indent=1))
        return
    text.show_rows(
        summary["errors"], {"view": "view", "channel": "channel", "model": "model", "rmse": "rms error (SI)"}
    )
    for line in summary["notes"]:
        text.console.print(escape(line), soft_wrap=True)
    text.console.print(f"trajectories: {escape(str(out / 'trajectories'))}", soft_wrap=True)


@app.command("extend")
def extend_command(
    target: Annotated[Path, typer.Argument(help="A package of Mana, or the URDF of a mechanism.", exists=True)],
    extension: Annotated[Path, typer.Argument(help="An extension.json of `mana gap find`.", exists=True)],
    out: Annotated[Path, typer.Option("--out", help="Folder for the new package or URDF.")] = Path("extended"),
    in_place: Annotated[
        bool, typer.Option("--in-place", help="Replace the package or URDF itself; ingesting again undoes it.")
    ] = False,
    measurement: Annotated[
        Path | None,
        typer.Option("--measurement", help="The folder it was found on; mass centre and inertia need it.", exists=True),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write what was measured into an asset, as far as its files can carry it, and judge the result anew.

    A package gets friction, restitution, mass, mass centre and inertia in USD, URDF and record (`measured`, with
    interval); a URDF gets joint friction, damping and limits. The rest is listed and stays in `extension.json`, which
    goes along. Nothing is replaced unless acceptance passes; exit code 1 when it does not, 2 while an ingest is at
    work in the folder of the new package.

    Example: `mana gap extend library/mug mug_gap/extension.json --out measured`
    """
    from cli.gap.extend import extend  # Loads USD and engine.

    answer = extend(target, extension, measurement, None if in_place else out)
    if as_json:
        print(json.dumps(answer.data(), indent=1))
    else:
        _show_extended(answer.data())
        for diagnostic in answer.diagnostics:
            text.show_diagnostic(diagnostic)
    raise typer.Exit(1 if answer.path is None else 0)


@app.command("effects")
def effects_command(
    name: Annotated[
        str | None, typer.Argument(help="One effect, e.g. joint.coulomb_friction; all when left out.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the effects that can be named, or explain one: formula, source, parameters, what looks like it.

    Examples: `mana gap effects`, `mana gap effects joint.backlash`
    """
    from cli.docs.effects import as_data
    from sim.effects.library import EFFECTS, effect  # Loads much of SciPy.

    if name is None:
        if as_json:
            print(json.dumps([as_data(e) for e in EFFECTS], indent=1))
        else:
            rows: list[dict[str, object]] = [
                {"name": e.name, "formula": e.formula, "reveals": e.reveals} for e in EFFECTS
            ]
            text.show_rows(rows, {"name": "effect", "formula": "formula", "reveals": "what shows it"})
        return
    try:
        one = effect(name)
    except KeyError as unknown:
        raise InvalidInput(finding("gap/unknown-effect", str(unknown.args[0]))) from None
    if as_json:
        print(json.dumps(as_data(one), indent=1))
    else:
        _explain(one, as_data(one))


@app.command("report")
def report_command(
    folder: Annotated[Path, typer.Argument(help="An output folder of `mana gap find`.", exists=True)],
    as_json: AsJson = False,
) -> None:
    """Write `report.html` anew from `report.json` and the pictures beside it.

    Example: `mana gap report door_gap`
    """
    from simgap.report.html import PAGE, REPORT, render_page

    report = GapReport.model_validate_json((folder / REPORT).read_bytes())
    write_atomically(folder / PAGE, render_page(report, folder).encode())
    if as_json:
        print(report.model_dump_json(indent=1))
    else:
        _show(report)
        text.console.print(f"report: {escape(str(folder / PAGE))}", soft_wrap=True)


def _read(folder: Path, quiet: bool) -> tuple[Measurement, tuple[Diagnostic, ...]]:
    """The measurement; its findings are shown, and errors end the command with exit code 1."""
    from simgap.recording.read import read  # Loads trimesh.

    outcome = read(folder)
    if not quiet:
        for diagnostic in outcome.diagnostics:
            text.show_diagnostic(diagnostic)
    if outcome.value is None:
        if quiet:
            print(json.dumps({"diagnostics": [d.model_dump(mode="json") for d in outcome.diagnostics]}, indent=1))
        raise typer.Exit(1)
    return outcome.value, outcome.diagnostics


def _show(report: GapReport) -> None:
    """Print the verdict, then its evidence."""
    from simgap.inference.verdict_text import share  # Loads scipy.

    style = _STATUS[report.verdict.status]
    text.console.print(f"[bold {style}]{report.verdict.status.replace('_', ' ')}[/]")
    text.console.print(escape(report.verdict.statement), soft_wrap=True)
    for group in report.verdict.ambiguous_groups:
        text.console.print(f"  {' or '.join(group.effects)}: {escape(group.experiment)}", soft_wrap=True)
    for check in report.traps:
        if check.status != "ok":
            text.console.print(f"  convention {check.status}: {check.name}: {escape(check.evidence)}", soft_wrap=True)
    comparison = report.engine_comparison
    for d in comparison.differences if comparison is not None else ():
        at = f"{comparison.engine.name} at {1e3 * (comparison.engine.step_s or 0.0):.3g} ms" if comparison else ""
        text.console.print(
            f"  {d.channel}: {at} is {d.between_engines:.2g} {d.unit} (rms, whole trials) from our roll-out of the "
            f"declared model; the recording is {d.ours_to_recording:.2g} {d.unit} from it",
            soft_wrap=True,
        )
    if comparison is not None and comparison.failure:
        text.console.print(f"  {comparison.engine.name}: {escape(comparison.failure)}", soft_wrap=True)
    rows = [
        {"view": g.view, "before": g.heldout_before, "after": g.heldout_after, "gain": share(g.reduction, g.ci95)}
        for g in report.gains
    ]
    headings = {"view": "held-out trials", "before": "error before (1 = noise)", "after": "after", "gain": "less error"}
    text.show_rows(rows, headings)


def _show_extended(answer: dict[str, Any]) -> None:
    """What went where, and what stays in extension.json."""
    for row in answer["written"]:
        values = ", ".join(f"{n} {p['value']:.4g} {p['unit']}" for n, p in row["parameters"].items())
        text.console.print(f"[green]written[/] {row['effect']}: {escape(values)}", soft_wrap=True)
        text.console.print(f"  {escape('; '.join(row['files']))}", soft_wrap=True)
    for row in answer["only_in_extension_json"]:
        text.console.print(f"[yellow]kept[/] {row['effect']} in extension.json: {escape(row['why'])}", soft_wrap=True)
    end = "refused by acceptance; nothing was written" if answer["path"] is None else answer["path"]
    text.console.print(escape(end), soft_wrap=True)


def _explain(one: Effect, data: dict[str, Any]) -> None:
    text.console.print(f"[bold]{one.name}[/bold]: {escape(one.formula)}", soft_wrap=True)
    for key in ("source", "reveals", "acts"):
        text.console.print(f"  {key}: {escape(data[key])}", soft_wrap=True)
    text.console.print(f"  measurements: {', '.join(one.kinds)}")
    carried = [f"{n.upper()} {data[n]}" for n in ("usd", "urdf") if data[n]]
    text.console.print(f"  in files: {escape('; '.join(carried) or 'extension.json only')}", soft_wrap=True)
    for other in one.confusables:
        text.console.print(f"  looks like {other.effect}; to tell: {escape(other.experiment)}", soft_wrap=True)
    headings = {"name": "parameter", "unit": "unit", "low": "from", "high": "to", "without_effect": "without effect"}
    text.show_rows(data["parameters"], headings)
