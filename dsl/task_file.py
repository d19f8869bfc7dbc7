"""Reads a task file (the paper's task fragment): a graph of stages with conditions, points and time limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from dsl.mapping_reader import MappingReader, in_text_order, place
from dsl.predicate_reader import read_predicate
from schemas.diagnostics import Diagnostic, Location, any_error, finding
from source.hint import did_you_mean
from source.include import read_tree
from source.tree import Scalar, Tree, TreeList, TreeMapping
from task.graph import WHOLE, TaskGraph, TaskNode, graph_faults

FILE_KEYS = ("task", "instruction", "time_limit_s", "failure", "roles", "graph_task_generator")
GRAPH_KEYS = ("nodes", "edges")
NODE_KEYS = (
    *("id", "success", "failure", "timeout_s", "score", "true_at_reset", "must_last", "instruction"),
    *("skills", "sensors"),  # of data generation; the judge does not read them
)


@dataclass(frozen=True)
class TaskFile:
    """A task as written. `roles` name objects for `@role` where the scene's tags do not; `places` of nodes by id."""

    graph: TaskGraph
    roles: Mapping[str, tuple[str, ...]]
    places: Mapping[str, Location]


def read_task(
    path: Path, root: Path | None = None, *, benchmark: bool = False
) -> tuple[TaskFile | None, tuple[Diagnostic, ...]]:
    """The task of a file, None where it has an error, and all findings. Includes stay inside `root`.

    In a benchmark the points have to be ten together as written.
    """
    tree, diagnostics = read_tree(path, (root or path.parent).resolve())
    if tree is None or any_error(diagnostics):
        return None, diagnostics
    findings = list(diagnostics)
    file = task_of(tree, path.stem, findings, benchmark=benchmark)
    return file, in_text_order(findings)


def task_of(
    tree: Tree, name: str, findings: list[Diagnostic], *, benchmark: bool = False, other_keys: Sequence[str] = ()
) -> TaskFile | None:
    """The task of a tree, None where it has an error; `other_keys` are not the task's and are passed over."""
    before = len(findings)
    if not isinstance(tree, TreeMapping):
        findings.append(finding("task/invalid-value", "a task file is a mapping", where=tree.at))
        return None
    file = MappingReader(tree, "a task file", findings)
    file.refuse_other_keys((*FILE_KEYS, *other_keys))
    generator = file.mapping("graph_task_generator", needed=True)
    nodes: list[TaskNode] = []
    places: dict[str, Location] = {}
    edges: tuple[tuple[str, str], ...] = ()
    if generator is not None:
        graph = MappingReader(generator, "`graph_task_generator`", findings)
        graph.refuse_other_keys(GRAPH_KEYS)
        nodes, places = _nodes(graph, findings)
        edges = _edges(graph, list(places), findings)
        _points(nodes, generator.at, findings, benchmark)
    failure = file.entry("failure")
    task_failure = (
        None if failure is None else read_predicate(failure.value, "`failure` of the task", findings, failure.at)
    )
    roles = _roles(file, findings)
    name, instruction = file.text("task") or name, file.text("instruction") or ""
    limit_s = file.number("time_limit_s", above=0.0)
    if any_error(findings[before:]):
        return None
    task = TaskGraph(name, tuple(nodes), edges, task_failure, limit_s, instruction)
    return TaskFile(task, roles, places)


def _nodes(graph: MappingReader, findings: list[Diagnostic]) -> tuple[list[TaskNode], dict[str, Location]]:
    """Nodes without an error; places of all that have an id."""
    nodes: list[TaskNode] = []
    places: dict[str, Location] = {}
    for item in graph.list("nodes", needed=True):
        if not isinstance(item, TreeMapping):
            findings.append(finding("task/invalid-value", "a node is a mapping", where=item.at))
            continue
        reader = MappingReader(item, "a node", findings)
        node_id = reader.text("id", needed=True)
        reader.what = f"the node `{node_id}`" if node_id else "a node"
        reader.refuse_other_keys(NODE_KEYS)
        if node_id is not None:
            if node_id in places:
                headline = f"the node `{node_id}` stands here again; first at line {places[node_id].line}"
                findings.append(finding("task/invalid-graph", headline, where=item.items["id"].at, value=node_id))
            places.setdefault(node_id, item.at)
        success = reader.entry("success", needed=True)
        failure = reader.entry("failure")
        conditions = [
            None if entry is None else read_predicate(entry.value, f"`{key}` of {reader.what}", findings, entry.at)
            for key, entry in (("success", success), ("failure", failure))
        ]
        points, timeout_s = reader.exact("score"), reader.number("timeout_s", above=0.0)
        flags = reader.flag("true_at_reset"), reader.flag("must_last")
        instruction = reader.text("instruction") or ""
        if conditions[0] is not None and node_id is not None:
            points = Fraction(1) if points is None else points
            nodes.append(TaskNode(node_id, conditions[0], conditions[1], timeout_s, points, *flags, instruction))
    return nodes, places


def _edges(graph: MappingReader, ids: list[str], findings: list[Diagnostic]) -> tuple[tuple[str, str], ...]:
    edges: list[tuple[str, str]] = []
    for item in graph.list("edges"):
        if not isinstance(item, TreeMapping):
            findings.append(finding("task/invalid-value", "an edge is a mapping with `src` and `dst`", where=item.at))
            continue
        reader = MappingReader(item, "an edge", findings)
        reader.refuse_other_keys(("src", "dst"))
        ends = [reader.text(key, needed=True) for key in ("src", "dst")]
        for key, end in zip(("src", "dst"), ends, strict=True):
            if end is not None and end not in ids:
                headline = f"`{key}: {end}` names no node{did_you_mean(end, ids)}"
                findings.append(finding("task/invalid-graph", headline, where=place(item.items[key]), value=end))
        if ends[0] in ids and ends[0] == ends[1]:
            headline = f"the node `{ends[0]}` waits for itself"
            findings.append(finding("task/invalid-graph", headline, where=place(item.items["dst"]), value=ends[0]))
        elif ends[0] in ids and ends[1] in ids:
            edges.append((str(ends[0]), str(ends[1])))
            circle = graph_faults(ids, tuple(edges))
            if circle:
                findings.append(finding("task/invalid-graph", circle[0], where=item.at))
                edges.pop()  # Further circles are then found by themselves.
    return tuple(edges)


def _points(nodes: list[TaskNode], at: Location, findings: list[Diagnostic], benchmark: bool) -> None:
    total = sum((node.points for node in nodes), start=Fraction(0))
    if nodes and total != WHOLE:
        code = "task/points-not-ten" if benchmark else "task/points-normalised"
        findings.append(
            finding(code, f"points are {float(total):g} together", where=at, value=float(total), bound=float(WHOLE))
        )


def _roles(file: MappingReader, findings: list[Diagnostic]) -> dict[str, tuple[str, ...]]:
    roles: dict[str, tuple[str, ...]] = {}
    written = file.mapping("roles")
    for name, entry in () if written is None else written.items.items():
        items = entry.value.items if isinstance(entry.value, TreeList) else (entry.value,)
        texts = tuple(item.text for item in items if isinstance(item, Scalar) and item.value is not None)
        if len(texts) != len(items) or not texts:
            headline = f"the role `{name}` takes the name of an object or a list of names"
            findings.append(finding("task/invalid-value", headline, where=entry.at))
        roles[name] = texts
    return roles
