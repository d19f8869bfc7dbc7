"""`mana plan`: draw scenes from a compiled plan, look at it, judge its samples."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from cli import text
from cli.plan import facts as plan_facts
from cli.plan.restrict import restrict_command
from jobs.cache import write_atomically
from runtime_plan import as_document, load, sample

app = typer.Typer(help="Draw scenes from a compiled plan: thousands in a moment, each valid.", no_args_is_help=True)
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]
PlanFile = Annotated[Path, typer.Argument(help="`plan.json`, of `mana scene compile`.", exists=True, dir_okay=False)]
Assets = Annotated[
    Path | None, typer.Option("--assets", help="Folder of packages: refuse them if they changed.", exists=True)
]
Seed = Annotated[int, typer.Option("--seed", min=0, max=2**64 - 1, help="The same seed gives the same samples.")]


@app.command("sample")
def sample_command(
    plan: PlanFile,
    out: Annotated[Path, typer.Option("--out", help="Where the samples go (JSON).")],
    n: Annotated[int, typer.Option("--n", min=1, help="How many.")] = 16,
    seed: Seed = 0,
    start: Annotated[int, typer.Option("--start", min=0, help="Index of the first: go on where you stopped.")] = 0,
    assets: Assets = None,
    as_json: AsJson = False,
) -> None:
    """Draw scenes: poses, assets, materials and lighting under the names of the program.

    Sample i depends on the seed and on i alone, so any split into files gives the same scenes.

    Example: `mana plan sample out/plan.json --n 1000 --seed 7 --out samples.json`
    """
    ready = load(plan, assets)
    drawn = sample(ready, n, seed, start)
    write_atomically(out, as_document(ready, drawn).model_dump_json().encode())
    if as_json:
        print(json.dumps({"plan": ready.sha256, "seed": seed, "start": start, "samples": n, "file": str(out)}))
        return
    layouts = len({(int(k), *row) for k, row in zip(drawn.combination, drawn.case.tolist(), strict=True)})
    text.console.print(f"{n} scenes of {len(drawn.names)} things from {layouts} layouts, written to {escape(str(out))}")


app.command("restrict")(restrict_command)


@app.command("inspect")
def inspect_command(
    plan: PlanFile,
    out: Annotated[Path | None, typer.Option("--out", help="A picture of cells and of samples (PNG).")] = None,
    assets: Assets = None,
    as_json: AsJson = False,
) -> None:
    """Say what is in a plan: combinations, pools with their cases, and how freely each thing moves.

    Example: `mana plan inspect out/plan.json --out cells.png`
    """
    ready = load(plan, assets)
    if out is not None:
        from cli.plan.picture import picture

        write_atomically(out, picture(ready))
    pools, things = plan_facts.pools(ready.document), plan_facts.things(ready.document)
    if as_json:
        made = ready.document.provenance.model_dump()
        facts = {"plan": ready.sha256, "provenance": made, "choices": plan_facts.choices(ready.document)}
        print(json.dumps({**facts, "pools": pools, "things": things}, indent=1))
        return
    text.show_rows(
        (
            {
                **row,
                "things": ", ".join(row["things"]),
                "quality": f"{row['quality']['least']:.2f} to {row['quality']['most']:.2f}",
                "families": ", ".join(f"{name} {count}" for name, count in row["families"].items()),
            }
            for row in pools
        ),
        {name: name for name in ("combination", "things", "cases", "quality", "families")},
    )
    text.show_rows(
        ({**row, "cell_cm": " x ".join(f"{100.0 * side:.1f}" for side in row["cell_m"])} for row in things),
        {
            "combination": "combination",
            "thing": "thing",
            "cell_cm": "cell (cm, median)",
            "yaw_rad": "yaw (rad, median)",
            "stances": "stances",
        },
    )


@app.command("verify")
def verify_command(
    plan: PlanFile,
    samples: Annotated[Path | None, typer.Option("--samples", help="A file of samples; else they are drawn.")] = None,
    n: Annotated[int, typer.Option("--n", min=1, help="How many to draw.")] = 10_000,
    seed: Seed = 0,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes; the verdict is the same for any number.")] = 1,
    out: Annotated[Path | None, typer.Option("--out", help="Write the report there as well.")] = None,
    as_json: AsJson = False,
) -> None:
    """Judge samples by their poses alone, with geometry code that shares nothing with the draw.

    Checks support, clearance, penetration, ranges, relations, keep-outs and reach of every scene. Exit code 1 when
    any is violated.

    Example: `mana plan verify out/plan.json --n 1000000 --jobs 4`
    """
    from cli.plan.verify import judge_drawn, judge_file

    with text.progress(quiet=as_json) as progress:
        report = judge_file(plan, samples) if samples else judge_drawn(plan, n, seed, jobs, progress)
    if out is not None:
        write_atomically(out, report.model_dump_json(indent=1).encode())
    if as_json:
        print(report.model_dump_json(indent=1))
    else:
        for row in report.violations[:20]:
            words = f"{row.kind} {row.label}".strip()
            sizes = f", {row.value:.6g} against {row.bound:.6g} {row.unit}" if row.unit else ""
            told = f"[red]sample {row.index}[/]: {escape(words)}: {escape(', '.join(row.things))}{sizes}"
            text.console.print(told, highlight=False)
        style = "red" if report.invalid else "green"
        text.console.print(f"[bold {style}]{report.invalid} invalid[/] of {report.checked} samples")
    raise typer.Exit(1 if report.invalid else 0)


@app.command("realise")
def realise_command(
    plan: PlanFile,
    index: Annotated[int, typer.Option("--index", min=0, help="Which sample of the stream.")] = 0,
    n: Annotated[int, typer.Option("--n", min=1, help="How many, from that one on.")] = 1,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option("--out", help="Folder; default: the plan's, beside its scenes.")] = None,
    as_json: AsJson = False,
) -> None:
    """Write samples as USD layers over the compiled scene: poses, materials with their physics, lighting.

    `sample-<index>.usda` opens alone and serves as session layer of the scene beside the plan. For PyBullet see
    `runtime_plan.realise`.

    Example: `mana plan realise out/plan.json --seed 7 --index 3`
    """
    from cli.plan.realise import Layers

    ready = load(plan, plan.parent / "packages")
    drawn = sample(ready, n, seed, index)
    layers, folder = Layers(ready, plan.parent), out or plan.parent
    folder.mkdir(parents=True, exist_ok=True)
    files = [layers.write(drawn, k, folder / f"sample-{index + k}.usda") for k in range(n)]
    if as_json:
        print(json.dumps({"plan": ready.sha256, "seed": seed, "files": [str(file) for file in files]}))
    else:
        for file in files:
            text.console.print(f"written to {escape(str(file))}", soft_wrap=True)


@app.command("render")
def render_command(
    plan: PlanFile,
    out: Annotated[Path, typer.Option("--out", help="The picture (PNG).")],
    n: Annotated[int, typer.Option("--n", min=1, max=100, help="How many scenes.")] = 16,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Draw a contact sheet of sampled scenes with their packages, from the USD layers that realise them.

    Example: `mana plan render out/plan.json --n 16 --out sheet.png`
    """
    from cli.plan.sheet import draw_sheet

    ready = load(plan, plan.parent / "packages")
    with text.progress(quiet=as_json) as progress:
        draw_sheet(ready, plan.parent, n, seed, out, progress)
    if as_json:
        print(json.dumps({"plan": ready.sha256, "seed": seed, "picture": str(out)}))
    else:
        text.console.print(f"picture: {escape(str(out))}", soft_wrap=True)
