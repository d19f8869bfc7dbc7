"""`mana task`: task graphs shown, and episodes judged by them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer
from rich.markup import escape
from rich.table import Table

from cli import source_text, text
from schemas.diagnostics import Diagnostic, InvalidInput, Location, any_error, finding
from schemas.task.episode_result import EpisodeResult

if TYPE_CHECKING:
    from dsl.task_file import TaskFile
    from schemas.task.logged_scene import LoggedScene
    from task.roles import RoleFault

app = typer.Typer(help="Show task graphs, and judge state logs and recorded episodes by them.", no_args_is_help=True)
FUNC = "_func"
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]
TaskPath = Annotated[Path, typer.Argument(help="A task file (YAML).", exists=True, dir_okay=False, metavar="TASK")]
Root = Annotated[
    Path | None, typer.Option("--root", help="Includes stay in this folder; default: the task's.", exists=True)
]
Benchmark = Annotated[bool, typer.Option("--benchmark", help="Refuse points that are not ten together.")]


@app.command("show")
def show_command(
    task: TaskPath,
    out: Annotated[Path | None, typer.Option("--out", help="Write the graph as a picture (PNG).")] = None,
    root: Root = None,
    benchmark: Benchmark = False,
    as_json: AsJson = False,
) -> None:
    """Print the stages of a task in their order, what each waits for, and what completes it; draw the graph.

    Example: `mana task show examples/tasks/stack_two_cubes.yaml --out stack.png`
    """
    file = _read(task, root, benchmark, as_json)
    if out is not None:
        from cli.task.pictures import draw_graph

        draw_graph(file.graph, out)
    if as_json:
        print(json.dumps(_document(file), indent=1, sort_keys=True))
        return
    graph = file.graph
    text.console.print(f"[bold]{escape(graph.name)}[/bold] {escape(graph.instruction)}", soft_wrap=True)
    table = Table(box=None, pad_edge=False)
    for heading in ("stage", "points", "waits for", "is done when"):
        table.add_column(heading, overflow="fold")
    for v in graph.order:
        node = graph.by_id[v]
        limit = f" (within {node.timeout_s:g} s)" if node.timeout_s is not None else ""
        words = f"{in_words(node.success.written())}{limit}"
        waits = ", ".join(graph.predecessors[v]) or "-"
        table.add_row(escape(v), f"{float(graph.weights[v]):g}", escape(waits), escape(words))
    text.console.print(table)
    if out is not None:
        text.console.print(f"graph: {escape(str(out))}", soft_wrap=True)


@app.command("score")
def score_command(
    task: TaskPath,
    logs: Annotated[list[Path], typer.Argument(help="State logs, recordings, folders of them.", exists=True)],
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for results (JSON), timelines and graphs (PNG).")
    ] = None,
    meshes: Annotated[Path | None, typer.Option("--meshes", help="Mesh files that models name.", exists=True)] = None,
    root: Root = None,
    benchmark: Benchmark = False,
    require_success: Annotated[
        bool, typer.Option("--require-success", help="Exit code 1 unless every episode succeeds.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Judge episodes from their states alone: events, score, first failure and labels of each.

    Contacts that a recording lacks are computed from its shapes. Roles (`@name`) are bound to the objects that the
    task names under `roles`, or to those that the scene tags so. Exit code 1 when an episode cannot be judged.

    Example: `mana task score examples/tasks/stack_two_cubes.yaml demos/ --out judged`
    """
    from cli.task.logs import log_files, logged_scenes

    file = _read(task, root, benchmark, as_json)
    results: list[tuple[str, EpisodeResult]] = []
    findings: list[Diagnostic] = []
    files = log_files(logs)
    for path, prefix in files.items():
        try:
            for logged in logged_scenes(path, prefix, meshes):
                result, faults = _judged(file, logged)
                findings += faults
                if result is None:
                    continue
                results.append((logged.name, result))
                if out is not None:
                    _write(file, logged.name, result, out)
                if not as_json:
                    _print_one(logged.name, result, brief=len(files) > 1)
        except InvalidInput as refused:
            findings.append(refused.diagnostic)
    if as_json:
        document = {
            "episodes": [{"episode": name, **each.model_dump(mode="json")} for name, each in results],
            "diagnostics": [each.model_dump(mode="json") for each in findings],
        }
        print(json.dumps(document, indent=1))
    else:
        source_text.show(findings, root or task.parent)
        if len(results) > 1:
            _print_summary([each for _, each in results])
    failed = require_success and not all(each.success for _, each in results)
    raise typer.Exit(1 if findings or failed else 0)


def _read(task: Path, root: Path | None, benchmark: bool, as_json: bool) -> TaskFile:
    """The task; prints findings, and ends with exit code 1 at an error."""
    from dsl.task_file import read_task

    file, diagnostics = read_task(task, root, benchmark=benchmark)
    if as_json and file is None:
        print(json.dumps({"diagnostics": [each.model_dump(mode="json") for each in diagnostics]}, indent=1))
    elif not as_json:
        source_text.show(diagnostics, root or task.parent)
    if file is None or any_error(diagnostics):
        raise typer.Exit(1)
    return file


def _judged(file: TaskFile, logged: LoggedScene) -> tuple[EpisodeResult | None, list[Diagnostic]]:
    """The result of one log, or what keeps it from being judged."""
    from task.evaluation import evaluate
    from task.frames import StateMissing
    from task.roles import bind_roles

    graph, faults = bind_roles(file.graph, logged.scene, file.roles)
    if faults:
        return None, [_role_finding(fault, logged.name, file) for fault in faults]
    try:
        return evaluate(graph, logged.log, logged.scene), []
    except StateMissing as missing:
        return None, [finding("task/state-missing", f"{logged.name}: {missing}")]


def _role_finding(fault: RoleFault, episode: str, file: TaskFile) -> Diagnostic:
    unbound = fault.kind == "unbound"
    words = "is no object of the scene" if unbound else "means several objects where one is needed"
    headline = f"{episode}: `{fault.name}` {words}; candidates: {', '.join(fault.candidates) or 'none'}"
    where = file.places.get(fault.node, Location())
    return finding("task/unbound-role" if unbound else "task/ambiguous-role", headline, where=where, value=fault.name)


def _write(file: TaskFile, name: str, result: EpisodeResult, out: Path) -> None:
    from cli.task.pictures import draw_graph, draw_timeline
    from jobs.cache import write_atomically

    stem = name.replace("/", "_")
    out.mkdir(parents=True, exist_ok=True)
    write_atomically(out / f"{stem}.json", (result.model_dump_json(indent=1) + "\n").encode())
    draw_timeline(file.graph, result, out / f"{stem}.timeline.png")
    draw_graph(file.graph, out / f"{stem}.graph.png", result)


def _print_one(name: str, result: EpisodeResult, *, brief: bool) -> None:
    from cli.task.pictures import verdict

    colour = "green" if result.success else "red" if result.failure else "yellow"
    text.console.print(f"[bold]{escape(name)}[/bold]: [{colour}]{escape(verdict(result))}[/{colour}]", soft_wrap=True)
    if brief:
        return
    table = Table(box=None, pad_edge=False)
    for heading in ("stage", "points", "became active", "done", "after", "in the end"):
        table.add_column(heading)
    for node in result.nodes:
        frames = ["-" if frame is None else str(frame) for frame in (node.activated, node.completed)]
        seconds = "-" if node.seconds is None else f"{node.seconds:.2f} s"
        end = node.stage if node.undone is None else f"undone in frame {node.undone}"
        table.add_row(escape(node.node), f"{node.points:g}", *frames, seconds, end)
    text.console.print(table)
    if result.failure is not None and result.failure.detail:
        text.console.print(f"first failure: {escape(result.failure.detail)}", soft_wrap=True)


def _print_summary(results: Sequence[EpisodeResult]) -> None:
    """Success rate, mean score, and for each stage how many episodes completed it."""
    count = len(results)
    successes = sum(each.success for each in results)
    mean = sum(each.score for each in results) / count
    text.console.print(f"{successes} of {count} episodes succeed, mean score {mean:.2f} of 10")
    for node in results[0].nodes:
        done = sum(any(event.node == node.node for event in each.events) for each in results)
        text.console.print(f"  {escape(node.node)}: {done} of {count}")


def _document(file: TaskFile) -> dict[str, object]:
    graph = file.graph
    return {
        "task": graph.name,
        "instruction": graph.instruction,
        "time_limit_s": graph.time_limit_s,
        "nodes": [
            {
                "id": v,
                "points": float(graph.weights[v]),
                "waits_for": list(graph.predecessors[v]),
                "success": graph.by_id[v].success.written(),
                "timeout_s": graph.by_id[v].timeout_s,
                "needs": sorted(graph.by_id[v].success.channels()),
            }
            for v in graph.order
        ],
        "roles": {name: list(objects) for name, objects in file.roles.items()},
    }


def in_words(written: dict[str, Any]) -> str:
    """A condition as a line: its name and the parameters that are not defaults."""
    parameters = ", ".join(f"{key}={_plain(value)}" for key, value in written.items() if key != FUNC)
    return f"{written[FUNC]}({parameters})"


def _plain(value: object) -> str:
    if isinstance(value, dict):
        return in_words(cast(dict[str, Any], value))
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_plain, cast(Sequence[object], value)))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
