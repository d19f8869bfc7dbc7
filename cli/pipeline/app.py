"""`mana pipeline`: pipelines are checked, explained and lowered to orders; no simulator, USD or renderer is started."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer
from rich.markup import escape

from cli import source_text, text
from schemas.diagnostics import Diagnostic, any_error

if TYPE_CHECKING:
    from schemas.task.orders import Orders

app = typer.Typer(
    help="Check pipelines before any simulator starts; explain them and print their orders.", no_args_is_help=True
)
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]
PipelinePath = Annotated[
    Path, typer.Argument(help="A pipeline (YAML).", exists=True, dir_okay=False, metavar="PIPELINE")
]
Root = Annotated[
    Path | None, typer.Option("--root", help="Includes stay in this folder; default: the pipeline's.", exists=True)
]
Benchmark = Annotated[bool, typer.Option("--benchmark", help="Refuse tasks whose points are not ten together.")]


@app.command("check")
def check_command(
    pipeline: PipelinePath,
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Packages: do assets have what conditions read?", exists=True)
    ] = None,
    root: Root = None,
    benchmark: Benchmark = False,
    as_json: AsJson = False,
) -> None:
    """Report every error of a pipeline and its fragments in one run, each with its file, line and column.

    With --assets conditions are checked against the records of the packages: volumes, surfaces, joints, categories.

    Example: `mana pipeline check examples/pipelines/pick_place/pipeline.yaml`
    """
    orders, diagnostics = _read(pipeline, root, benchmark, assets)
    if as_json:
        document = {
            "sound": orders is not None,
            "orders": [] if orders is None else [{"name": o.name, "sha256": o.digest} for o in orders.all()],
            "diagnostics": [each.model_dump(mode="json") for each in diagnostics],
        }
        print(json.dumps(document, indent=1))
    else:
        source_text.show(diagnostics, root or pipeline.parent)
        if orders is not None:
            counts = {
                "scene": len(orders.scenes),
                "robot": len(orders.robots),
                "task": len(orders.tasks),
                "assembly": len(orders.assemblies),
                "rollout": len(orders.rollouts),
            }
            words = ", ".join(f"{count} {kind}" for kind, count in counts.items())
            text.console.print(f"[green]sound[/green]: orders for {words}", soft_wrap=True)
    raise typer.Exit(1 if any_error(diagnostics) else 0)


@app.command("orders")
def orders_command(
    pipeline: PipelinePath, root: Root = None, benchmark: Benchmark = False, as_json: AsJson = False
) -> None:
    """Print the lowered orders as JSON: the same bytes for the same pipeline, to store, hash and compare.

    Example: `mana pipeline orders examples/pipelines/pick_place/pipeline.yaml > orders.json`
    """
    orders = _sound(pipeline, root, benchmark)
    print(json.dumps(orders.model_dump(mode="json"), indent=1, sort_keys=True))


@app.command("explain")
def explain_command(
    pipeline: PipelinePath, root: Root = None, benchmark: Benchmark = False, as_json: AsJson = False
) -> None:
    """Print what a pipeline makes: each environment with its parts and bound roles, and who drives it.

    Example: `mana pipeline explain examples/pipelines/pick_place/pipeline.yaml`
    """
    orders = _sound(pipeline, root, benchmark)
    if as_json:
        print(json.dumps({"lines": _lines(orders)}, indent=1))
        return
    for line in _lines(orders):
        text.console.print(escape(line), soft_wrap=True, highlight=False)


@app.command("graph")
def graph_command(
    pipeline: PipelinePath, root: Root = None, benchmark: Benchmark = False, as_json: AsJson = False
) -> None:
    """Print which order is made from which, as a graph in the DOT language.

    Example: `mana pipeline graph examples/pipelines/pick_place/pipeline.yaml | dot -Tsvg > pipeline.svg`
    """
    orders = _sound(pipeline, root, benchmark)
    edges = [
        (f"{kind} {name}", f"assembly {order.name}")
        for order in orders.assemblies
        for kind, name in (("scene", order.scene), ("robot", order.robot), ("task", order.task))
    ]
    edges += [(f"assembly {order.env_ref}", f"rollout {order.name}") for order in orders.rollouts]
    if as_json:
        print(json.dumps({"edges": edges}, indent=1))
        return
    print("digraph pipeline {\n  rankdir=LR;")
    for a, b in edges:
        print(f"  {json.dumps(a)} -> {json.dumps(b)};")
    print("}")


@app.command("export")
def export_command(
    pipeline: PipelinePath,
    out: Annotated[Path, typer.Option("--out", help="Folder for a file of each environment.")],
    assets: Annotated[str, typer.Option("--assets", help="Where the packages lie for Arena.")] = "packages",
    lossy: Annotated[
        bool, typer.Option("--lossy", help="Write what Arena can hold, with a list of what is lost.")
    ] = False,
    root: Root = None,
    benchmark: Benchmark = False,
    as_json: AsJson = False,
) -> None:
    """Write each environment as a graph of Isaac Lab Arena (YAML): one stage, a chain, or stages in any order.

    Arena has no partial order: other tasks are refused, or lose their edges with --lossy. Exit code 1 when an
    environment is refused.

    Example: `mana pipeline export examples/pipelines/pick_place/pipeline.yaml --out arena --lossy`
    """
    from dsl.arena import NotExportable, export_environment
    from jobs.cache import write_atomically

    orders = _sound(pipeline, root, benchmark)
    rows: list[dict[str, object]] = []
    for assembly in orders.assemblies:
        try:
            graph = export_environment(orders, assembly, assets, lossy=lossy)
        except NotExportable as refused:
            rows.append({"environment": assembly.name, "file": None, "lost": str(refused).splitlines()})
            continue
        file = out / f"{assembly.name}.yaml"
        write_atomically(file, yaml_text(graph.document).encode())
        rows.append({"environment": assembly.name, "file": str(file), "lost": list(graph.lost)})
    if as_json:
        print(json.dumps({"environments": rows}, indent=1))
    else:
        for row in rows:
            words = "refused" if row["file"] is None else f"written to {row['file']}"
            text.console.print(escape(f"{row['environment']}: {words}"), soft_wrap=True)
            for line in cast(list[str], row["lost"]):
                text.console.print(escape(f"  not held: {line}"), soft_wrap=True)
    raise typer.Exit(1 if any(row["file"] is None for row in rows) else 0)


def yaml_text(document: dict[str, Any]) -> str:
    """A document as YAML in block style."""
    from ruamel.yaml import YAML

    yaml, stream = YAML(typ="safe", pure=True), io.StringIO()
    yaml.default_flow_style = False
    yaml.dump(document, stream)
    return stream.getvalue()


def _read(
    pipeline: Path, root: Path | None, benchmark: bool, assets: Path | None = None
) -> tuple[Orders | None, tuple[Diagnostic, ...]]:
    from dsl.pipeline_file import read_pipeline

    file, diagnostics = read_pipeline(pipeline, root, assets=assets, benchmark=benchmark)
    return (None if file is None else file.orders), diagnostics


def _sound(pipeline: Path, root: Path | None, benchmark: bool) -> Orders:
    """The orders; prints findings and ends with exit code 1 where there is an error."""
    orders, diagnostics = _read(pipeline, root, benchmark)
    if orders is None:
        source_text.show(diagnostics, root or pipeline.parent)
        raise typer.Exit(1)
    return orders


def _lines(orders: Orders) -> list[str]:
    tasks = {task.name: task for task in orders.tasks}
    lines: list[str] = []
    for order in orders.assemblies:
        task = tasks[order.task]
        lines.append(f"{order.name}: scene {order.scene}, robot {order.robot}, task {order.task}")
        lines += [f"  {role} is {', '.join(objects)}" for role, objects in order.bindings.items()]
        for node in task.nodes:
            waits = f", after {', '.join(node.waits_for)}" if node.waits_for else ""
            points = node.points[0] / node.points[1]
            lines.append(f"  stage {node.id} ({points:g} points): {node.success['_func']}{waits}")
    lines += [
        f"{order.name}: {order.teacher} in {order.env_ref} for {', '.join(order.modes)}" for order in orders.rollouts
    ]
    return lines
