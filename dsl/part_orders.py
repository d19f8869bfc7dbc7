"""Reads the orders of parts: scenes, robots and tasks. Each is a fragment with a name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dsl.mapping_reader import MappingReader
from dsl.task_file import TaskFile, task_of
from scenec.source.checks import check_program
from scenec.source.language import SECTIONS
from scenec.source.validate import validate
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.scene.program import SceneProgram
from schemas.task.orders import RobotOrder, SceneOrder, TaskNodeOrder, TaskOrder
from source.include import lift_definition
from source.tree import Scalar, Spans, Tree, TreeList, TreeMapping, child, plain

NAME, GRIPPER = "name", "gripper_variant"
FRAGMENT_NAMES = {"scene": (("definition", "scene_type"), ("scene",)), "robot": (("robot",),), "task": (("task",),)}


@dataclass
class Parts:
    """Orders of parts by name, what they were read from, and where; an order with an error is None.

    `tag_places` has for each scene where its tags are written.
    """

    scenes: dict[str, tuple[SceneOrder, SceneProgram] | None] = field(
        default_factory=dict[str, tuple[SceneOrder, SceneProgram] | None]
    )
    robots: dict[str, RobotOrder | None] = field(default_factory=dict[str, RobotOrder | None])
    tasks: dict[str, tuple[TaskOrder, TaskFile] | None] = field(
        default_factory=dict[str, tuple[TaskOrder, TaskFile] | None]
    )
    places: dict[tuple[str, str], Location] = field(default_factory=dict[tuple[str, str], Location])
    tag_places: dict[str, dict[str, Location]] = field(default_factory=dict[str, dict[str, Location]])


def read_part(kind: str, tree: Tree, parts: Parts, findings: list[Diagnostic], *, benchmark: bool) -> None:
    """Adds the order of one fragment to `parts`."""
    if not isinstance(tree, TreeMapping):
        findings.append(finding("pipeline/invalid-value", f"an order of a {kind} is a mapping", where=tree.at))
        return
    name = _name(kind, tree)
    if name is None:
        findings.append(finding("pipeline/unnamed-order", f"an order of a {kind} has no name", where=tree.at))
        return
    table: Mapping[str, object] = {"scene": parts.scenes, "robot": parts.robots, "task": parts.tasks}[kind]
    if name in table:
        first = parts.places[kind, name]
        headline = f"the {kind} `{name}` is ordered again; first at {first}"
        findings.append(finding("pipeline/name-twice", headline, where=tree.at, value=name))
        return
    parts.places[kind, name] = tree.at
    if kind == "scene":
        parts.scenes[name] = _scene(name, tree, findings)
        parts.tag_places[name] = _tag_places(tree)
    elif kind == "robot":
        parts.robots[name] = _robot(name, tree, findings)
    else:
        parts.tasks[name] = _task(name, tree, findings, benchmark=benchmark)


def _name(kind: str, tree: TreeMapping) -> str | None:
    """The order's own name, else that of its fragment."""
    for path in ((NAME,), *FRAGMENT_NAMES[kind]):
        value = child(tree, path)
        if isinstance(value, Scalar) and value.value is not None:
            return value.text
    return None


def without(tree: TreeMapping, *keys: str) -> TreeMapping:
    """The mapping without some keys."""
    return TreeMapping({key: entry for key, entry in tree.items.items() if key not in keys}, tree.at)


def _scene(name: str, tree: TreeMapping, findings: list[Diagnostic]) -> tuple[SceneOrder, SceneProgram] | None:
    program_tree = lift_definition(without(tree, NAME), SECTIONS, findings)
    spans = Spans(program_tree, tree.at.file)
    program, diagnostics = validate(program_tree, spans)
    findings += diagnostics
    if program is None:
        return None
    checked = check_program(program, spans)
    findings += checked
    if any(each.severity.value == "error" for each in checked):
        return None
    return SceneOrder(name=name, program=dict(plain(program_tree))), program


def _tag_places(tree: TreeMapping) -> dict[str, Location]:
    """Where each tag of a scene's objects stands first."""
    places: dict[str, Location] = {}
    objects = child(tree, ("objects",))
    for item in objects.items if isinstance(objects, TreeList) else ():
        tags = child(item, ("semantic_tags",))
        for tag in tags.items if isinstance(tags, TreeList) else ():
            if isinstance(tag, Scalar):
                places.setdefault(tag.text, tag.at)
    return places


def _robot(name: str, tree: TreeMapping, findings: list[Diagnostic]) -> RobotOrder:
    reader = MappingReader(tree, f"the robot `{name}`", findings, area="pipeline")
    fragment = plain(without(tree, NAME, GRIPPER))
    return RobotOrder(name=name, gripper_variant=reader.text(GRIPPER), fragment=dict(fragment))


def _task(
    name: str, tree: TreeMapping, findings: list[Diagnostic], *, benchmark: bool
) -> tuple[TaskOrder, TaskFile] | None:
    file = task_of(tree, name, findings, benchmark=benchmark, other_keys=(NAME,))
    if file is None:
        return None
    graph = file.graph
    nodes = tuple(
        TaskNodeOrder(
            id=v,
            waits_for=graph.predecessors[v],
            success=graph.by_id[v].success.written(),
            failure=None if (failure := graph.by_id[v].failure) is None else failure.written(),
            timeout_s=graph.by_id[v].timeout_s,
            points=(graph.weights[v].numerator, graph.weights[v].denominator),
            true_at_reset=graph.by_id[v].true_at_reset,
            must_last=graph.by_id[v].must_last,
            instruction=graph.by_id[v].instruction,
        )
        for v in graph.order
    )
    order = TaskOrder(
        name=name,
        instruction=graph.instruction,
        time_limit_s=graph.time_limit_s,
        failure=None if graph.failure is None else graph.failure.written(),
        roles=dict(file.roles),
        nodes=nodes,
    )
    return order, file
