"""`mana scene`: programs become whole, checked scenes, or an account of why there is none."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.markup import escape

from cli import source_text, text
from cli.codes import code_info
from cli.scene.verdicts import STYLE, show_verdicts
from schemas.codes import CODES
from schemas.diagnostics import InvalidInput, finding
from schemas.scene.compiled import CompileReport

if TYPE_CHECKING:
    from scenec.compile import Compiled

app = typer.Typer(help="Compile scene programs: a whole scene, a proof that there is none, or a limit.")
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]
Program = Annotated[Path, typer.Argument(help="A scene program (YAML).", exists=True, dir_okay=False)]
Assets = Annotated[
    Path | None, typer.Option("--assets", help="A folder of packages, of `mana assets ingest`.", exists=True)
]
Root = Annotated[
    Path | None, typer.Option("--root", help="Includes stay in this folder; default: the program's.", exists=True)
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Another seed gives another scene; the same, the same.")]
Budget = Annotated[int | None, typer.Option("--budget", min=1, help="Steps of the search for each combination.")]
_WORDS = {
    "compiled": "compiled",
    "infeasible": "infeasible: there is no such scene",
    "budget_exhausted": "not found within the budget, which proves nothing",
    "invalid_program": "invalid program",
}


@app.command("compile")
def compile_command(
    program: Program,
    out: Annotated[Path, typer.Option("--out", help="Where stages, report and pictures go.")],
    assets: Assets = None,
    seed: Seed = 0,
    budget: Budget = None,
    root: Root = None,
    emit: Annotated[
        Literal["graph"] | None, typer.Option("--emit", help="Also write the interaction graph (DOT and JSON).")
    ] = None,
    let_go: Annotated[
        bool, typer.Option("--settle/--no-settle", help="Let the scene go in PyBullet: does everything stay?")
    ] = True,
    diversity: Annotated[
        float, typer.Option("--diversity", min=0.0, help="Cases of plan.json: 1 usual, more cover more, 0 for no plan.")
    ] = 1.0,
    pictures: Annotated[
        bool, typer.Option("--pictures/--no-pictures", help="Draw the scene from above and in perspective.")
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Compile a program to a USD stage with all it refers to and a plan of many scenes, or say why there is none.

    The scene is complete and was checked by a judge that shares no code with the solver; when any combination of
    variants fails nothing is written but the report. Exit code 1 when there is no scene, or when an object does not
    stay where it was put (more than 5 mm or 3 degrees).

    Example: `mana scene compile examples/scenes/table_setting.yaml --assets library --out breakfast`
    """
    from cli.scene.output import draw_perspective, draw_plan, write_graphs, write_output, write_report
    from scenec.compile import compile_program
    from scenec.solve import DEFAULT_BUDGET

    with text.progress(quiet=as_json) as progress:
        task = progress.add_task("compiling", total=4)
        compiled = compile_program(
            program, assets, seed=seed, budget=budget or DEFAULT_BUDGET, root=root, diversity=diversity or None
        )
        progress.update(task, advance=1, description="writing")
        report = write_output(compiled, assets, out)
        if emit == "graph":
            write_graphs(compiled, out)
        progress.update(task, advance=1, description="settling")
        if report.scene is not None and let_go:
            from cli.scene.settle import settle

            report = report.model_copy(update={"settling": settle(out / report.scene)})
        progress.update(task, advance=1, description="drawing")
        if pictures:
            draw_plan(compiled, out)
            if report.scene is not None:
                draw_perspective(out / report.scene)
        write_report(report, out)
        progress.update(task, advance=1)
    _tell(report, root or program.parent, as_json)
    if not as_json:
        if compiled.plan is not None:
            cases = sum(len(pool.cases) for one in compiled.plan.combinations for pool in one.pools)
            spent = f"{cases} cases in {report.phases['plan']:.1f} s; --diversity 0 leaves it out"
            text.console.print(f"plan.json for `mana plan sample`: {spent}", highlight=False, soft_wrap=True)
        text.console.print(f"written to {escape(str(out))}", soft_wrap=True)
    raise typer.Exit(_exit_code(report))


@app.command("diagnose")
def diagnose_command(
    program: Program,
    assets: Assets = None,
    seed: Seed = 0,
    budget: Budget = None,
    root: Root = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the picture of what stands in the way.")] = None,
    as_json: AsJson = False,
) -> None:
    """Say what is wrong with a program: the lines at fault, the least set that conflicts, edits that do work.

    Everything wrong is reported in one run. Of what cannot be satisfied it names constraints that conflict, and says
    whether the others hold together without any one of them; suggestions marked `tried` were compiled again.

    Example: `mana scene diagnose examples/scenes/three_cycle.yaml --out why`
    """
    from scenec.compile import compile_program
    from scenec.solve import DEFAULT_BUDGET

    with text.progress(quiet=as_json) as progress:
        progress.add_task("compiling", total=None)
        compiled = compile_program(program, assets, seed=seed, budget=budget or DEFAULT_BUDGET, root=root)
    picture = _picture(compiled, out)
    _tell(compiled.report, root or program.parent, as_json)
    if picture is not None and not as_json:
        text.console.print(f"picture: {escape(str(picture))}", soft_wrap=True)
    raise typer.Exit(_exit_code(compiled.report))


@app.command("render")
def render_command(
    program: Program,
    out: Annotated[Path, typer.Option("--out", help="Where the pictures go.")] = Path("pictures"),
    assets: Assets = None,
    seed: Seed = 0,
    root: Root = None,
    as_json: AsJson = False,
) -> None:
    """Draw the compiled scene from above, or what stands in the way of one.

    Example: `mana scene render examples/scenes/table_setting.yaml --assets library --out pictures`
    """
    from scenec.compile import compile_program

    compiled = compile_program(program, assets, seed=seed, root=root)
    picture = _picture(compiled, out)
    if as_json:
        print(json.dumps({"verdict": compiled.report.verdict, "picture": picture and str(picture)}))
    else:
        if picture is None:
            _tell(compiled.report, root or program.parent, as_json)
        else:
            text.console.print(f"picture: {escape(str(picture))}", soft_wrap=True)
    raise typer.Exit(_exit_code(compiled.report))


@app.command("edit")
def edit_command(
    program: Program,
    assets: Assets = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the picture, drawn anew each time.")] = None,
    seed: Seed = 0,
    budget: Budget = None,
    root: Root = None,
    as_json: AsJson = False,
) -> None:
    """Compile a program again each time it is saved: what the edit does not concern is kept, until Ctrl-C.

    Things stay where they stood as far as they can; each line says how many moved. `--json` prints one line an edit.

    Example: `mana scene edit examples/scenes/table_setting.yaml --assets library --out pictures`
    """
    from cli.scene.edit import moved, saved
    from scenec.session import Session
    from scenec.solve import DEFAULT_BUDGET

    session = Session(assets, seed=seed, budget=budget or DEFAULT_BUDGET, root=root)
    before = None
    try:
        for compiled in saved(session, program, root or program.parent):
            changed, before = moved(before, compiled), session.last
            picture = _picture(compiled, out)
            if as_json:
                print(json.dumps({"moved": changed, "report": compiled.report.model_dump(mode="json")}), flush=True)
                continue
            _tell(compiled.report, root or program.parent, False)
            said = "" if changed is None else f"{changed} of {len(compiled.scenes[0].objects)} things moved; "
            shown = "" if picture is None else f"picture: {escape(str(picture))}; "
            text.console.print(f"{said}{shown}waiting for the next edit", highlight=False, soft_wrap=True)
    except KeyboardInterrupt:
        return


@app.command("explain")
def explain_command(
    code: Annotated[str, typer.Argument(help="A diagnostic code, e.g. scene/relation-cycle.")], as_json: AsJson = False
) -> None:
    """Explain a diagnostic code: what it means, why it matters, what to do.

    Example: `mana scene explain scene/relation-cycle`
    """
    from source.hint import did_you_mean

    info = code_info(code)
    if info is None:
        hint = did_you_mean(code, [name for name in CODES if name.startswith("scene/")])
        raise InvalidInput(finding("scene/unknown-name", f"there is no code `{code}`{hint}"))
    if as_json:
        print(json.dumps({"code": code, **info._asdict()}, indent=1))
        return
    text.console.print(f"[bold]{code}[/] ({info.severity}): {escape(info.title)}.", soft_wrap=True)
    text.console.print(escape(info.why), soft_wrap=True)
    text.console.print(f"[bold]help[/]: {escape(info.help)}", soft_wrap=True)


@app.command("schema")
def schema_command(
    as_json: Annotated[bool, typer.Option("--json", help="The output is JSON in any case.")] = True,
) -> None:
    """The JSON Schema of scene programs, for editors that complete and check while one types.

    Example: `mana scene schema > scene.schema.json`
    """
    from scenec.source.language import editor_schema

    print(json.dumps(editor_schema(), indent=1, sort_keys=True))


def _picture(compiled: Compiled, out: Path | None) -> Path | None:
    if out is None:
        return None
    from cli.scene.output import draw_plan

    return draw_plan(compiled, out)


def _exit_code(report: CompileReport) -> int:
    return 0 if report.verdict == "compiled" and all(row.stayed for row in report.settling) else 1


def _tell(report: CompileReport, root: Path, as_json: bool) -> None:
    """Findings with their lines, the conflict, what was tried, then the verdict."""
    if as_json:
        print(report.model_dump_json(indent=1))
        return
    source_text.show(report.diagnostics, root)
    if report.conflict:
        least = (
            "minimal: without any one of them the others hold together"
            if report.minimal
            else "a smaller set may conflict as well"
        )
        text.console.print(f"[bold]conflict[/] ({least}):")
        for member in report.conflict:
            text.console.print(
                f"  {escape(member.path)} at {member.file}:{member.line}:{member.column}", highlight=False
            )
    for suggestion in report.suggestions:
        state = "[green]tried[/]" if suggestion.verified else "[dim]not tried[/]"
        text.console.print(f"  {state}: {escape(suggestion.edit)}", soft_wrap=True)
    show_verdicts(report)
    fallen = [row for row in report.settling if not row.stayed]
    for row in fallen:
        turned_deg = math.degrees(row.turned_rad)
        text.console.print(
            f"[yellow]does not stay[/]: {escape(row.id)} moved {1000 * row.moved_m:.1f} mm, turned {turned_deg:.1f} deg"
        )
    if report.settling and not fallen:
        worst = max(report.settling, key=lambda row: row.moved_m)
        text.console.print(
            f"let go in PyBullet all {len(report.settling)} objects stay; {escape(worst.id)} moved most, "
            f"{1000 * worst.moved_m:.2f} mm",
            highlight=False,
        )
    text.console.print(
        f"[bold {STYLE[report.verdict]}]{_WORDS[report.verdict]}[/] ({report.seconds:.2f} s)", highlight=False
    )
