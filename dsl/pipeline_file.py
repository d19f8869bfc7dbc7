"""Reads a pipeline: orders of parts, assemblies and rollouts, lowered to `schemas.task.orders`; nothing is made.

Sections stand in the order in which they are fulfilled: factories and orders of parts, then assemblies, then rollouts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import cast, get_args

import numpy as np

from dsl.mapping_reader import MappingReader, in_text_order, place
from dsl.part_orders import Parts, read_part
from dsl.scene_needs import missing_needs
from dsl.task_file import TaskFile
from schemas.diagnostics import Diagnostic, Label, Location, any_error, finding
from schemas.scene.program import SceneProgram
from schemas.task.orders import AssemblyOrder, Mode, Orders, RolloutOrder
from schemas.task.scene_facts import ObjectFacts, SceneFacts
from source.hint import did_you_mean
from source.include import read_tree
from source.tree import Scalar, Tree, TreeMapping, plain
from task.roles import MARK, bind_roles

PARTS = {"scene_orders": "scene", "robot_orders": "robot", "task_orders": "task"}
FACTORIES = ("data_services", "scene_factory", "robot_factory", "task_factory", "assembly_factory")
ASSEMBLIES, ROLLOUTS = "assembly_orders", "rollout"
# Earlier sections may not stand below later ones.
RANKS = {**dict.fromkeys((*FACTORIES, *PARTS), 0), "data_services": -1, ASSEMBLIES: 1, ROLLOUTS: 2}
GENERATOR_KEYS = ("name", "scene_generator_name", "robot_generator_name", "task_generator_name")
ROLLOUT_KEYS = ("name", "env_ref", "modes", "planner", "teacher")
WORLD_OBJECTS = ("background",)  # places that scenes name beside their objects


@dataclass(frozen=True)
class PipelineFile:
    """The orders of a pipeline, and where each was written, by kind and name."""

    orders: Orders
    places: Mapping[tuple[str, str], Location]


def read_pipeline(
    path: Path, root: Path | None = None, *, assets: Path | None = None, benchmark: bool = False
) -> tuple[PipelineFile | None, tuple[Diagnostic, ...]]:
    """The pipeline of a file, None where it has an error, and all findings in the order of the text.

    Includes stay inside `root`. With `benchmark`, points of tasks must be ten together as written. With `assets`, a
    folder of packages, conditions are also checked against the records of the scene's assets.
    """
    tree, diagnostics = read_tree(path, (root or path.parent).resolve())
    if tree is None or any_error(diagnostics):
        return None, diagnostics
    findings = list(diagnostics)
    if not isinstance(tree, TreeMapping):
        findings.append(finding("pipeline/invalid-value", "a pipeline is a mapping", where=tree.at))
        return None, tuple(findings)
    reader = MappingReader(tree, "a pipeline", findings, area="pipeline")
    reader.refuse_other_keys(list(RANKS))
    _check_order(tree, findings)
    parts = Parts()
    for key, kind in PARTS.items():
        for item in reader.list(key):
            read_part(kind, item, parts, findings, benchmark=benchmark)
    assemblies = _assemblies(reader, parts, findings, assets)
    rollouts = _rollouts(reader, assemblies, findings)
    _report_unused(parts, assemblies, findings)
    if any_error(findings):
        return None, in_text_order(findings)
    orders = Orders(
        factories=_factories(reader),
        scenes=tuple(order[0] for order in parts.scenes.values() if order),
        robots=tuple(order for order in parts.robots.values() if order),
        tasks=tuple(order[0] for order in parts.tasks.values() if order),
        assemblies=tuple(order for order in assemblies.values() if order),
        rollouts=rollouts,
    )
    return PipelineFile(orders, parts.places), in_text_order(findings)


def _check_order(tree: TreeMapping, findings: list[Diagnostic]) -> None:
    highest, above = min(RANKS.values()), ""
    for key, entry in tree.items.items():
        rank = RANKS.get(key, highest)
        if rank < highest:
            headline = f"`{key}` stands below `{above}`, which is made from it"
            findings.append(finding("pipeline/illegal-order", headline, where=entry.at, value=key))
        elif key in RANKS and rank > highest:
            highest, above = rank, key


def _factories(reader: MappingReader) -> dict[str, str]:
    factories: dict[str, str] = {}
    for key in FACTORIES:
        block = reader.tree.items.get(key)
        if block is not None and isinstance(block.value, TreeMapping):
            named = block.value.items.get("type")
            if named is not None and isinstance(named.value, Scalar):
                factories[key] = named.value.text
    return factories


def _assemblies(
    reader: MappingReader, parts: Parts, findings: list[Diagnostic], assets: Path | None
) -> dict[str, AssemblyOrder | None]:
    assemblies: dict[str, AssemblyOrder | None] = {}
    for item in reader.list(ASSEMBLIES):
        generator = _generator(item, findings)
        if generator is None:
            continue
        assembly = MappingReader(generator, "an assembly", findings, area="pipeline")
        assembly.refuse_other_keys(GENERATOR_KEYS)
        names = [assembly.text(key, needed=True) for key in GENERATOR_KEYS]
        if names[0] is None:
            continue
        if names[0] in assemblies:
            where = place(generator.items["name"])
            headline = f"the assembly `{names[0]}` is ordered again"
            findings.append(finding("pipeline/name-twice", headline, where=where, value=names[0]))
            continue
        tables: tuple[tuple[str, Iterable[str]], ...] = (
            ("scene", parts.scenes),
            ("robot", parts.robots),
            ("task", parts.tasks),
        )
        known = [
            _refers(generator, key, name, kind, table, findings)
            for key, name, (kind, table) in zip(GENERATOR_KEYS[1:], names[1:], tables, strict=True)
        ]
        assemblies[names[0]] = None
        if all(known):
            bindings = _bindings(names[0], str(names[1]), str(names[3]), parts, findings, assets)
            assemblies[names[0]] = AssemblyOrder(
                name=names[0], scene=str(names[1]), robot=str(names[2]), task=str(names[3]), bindings=bindings
            )
    return assemblies


def _generator(item: Tree, findings: list[Diagnostic]) -> TreeMapping | None:
    if isinstance(item, TreeMapping):
        order = MappingReader(item, "an order of an assembly", findings, area="pipeline")
        order.refuse_other_keys(("assembly_generator",))
        return order.mapping("assembly_generator", needed=True)
    findings.append(finding("pipeline/invalid-value", "an order of an assembly is a mapping", where=item.at))
    return None


def _refers(
    block: TreeMapping, key: str, name: str | None, kind: str, table: Iterable[str], findings: list[Diagnostic]
) -> bool:
    """Whether a name is that of an order; a finding where it is not."""
    known = list(table)
    if name is None or name in known:
        return name is not None
    hint = did_you_mean(name, known) or f"; there {'is' if len(known) == 1 else 'are'} {', '.join(known) or 'none'}"
    findings.append(
        finding(
            "pipeline/unknown-name", f"no {kind} is called `{name}`{hint}", where=place(block.items[key]), value=name
        )
    )
    return False


def _bindings(
    assembly: str, scene: str, task: str, parts: Parts, findings: list[Diagnostic], assets: Path | None
) -> dict[str, tuple[str, ...]]:
    """The objects that play each role of the task in the scene; findings where none or too many could."""
    scene_part, task_part = parts.scenes[scene], parts.tasks[task]
    if scene_part is None or task_part is None:
        return {}  # What is wrong with them is already reported.
    file, facts = task_part[1], named_objects(scene_part[1])
    graph, faults = bind_roles(file.graph, facts, file.roles)
    for fault in faults:
        unbound = fault.kind == "unbound"
        words = "is no object of" if unbound else "means several objects of"
        candidates = ", ".join(fault.candidates) or "none"
        headline = f"`{fault.name}` of the task `{task}` {words} the scene `{scene}`; candidates: {candidates}"
        code = "pipeline/unbound-role" if unbound else "pipeline/ambiguous-role"
        where = file.places.get(fault.node, parts.places["task", task])
        labels = _near_tags(fault.name, parts.tag_places.get(scene, {})) if unbound else ()
        findings.append(finding(code, f"{assembly}: {headline}", where=where, value=fault.name, labels=labels))
    for lacking in () if faults else missing_needs(graph, scene_part[1], assets):
        where = file.places.get(lacking.node, parts.places["task", task])
        headline = f"{assembly}: in the scene `{scene}` {lacking.words}"
        findings.append(finding("pipeline/unmet-need", headline, where=where, value=lacking.words))
    roles = {name for name in _names(file) if name.startswith(MARK)}
    return {
        role: tuple(file.roles.get(role.removeprefix(MARK), facts.tagged(role.removeprefix(MARK))))
        for role in sorted(roles)
    }


def _near_tags(role: str, places: Mapping[str, Location]) -> tuple[Label, ...]:
    """Where the scene has a tag that is spelt almost like the role."""
    tag = role.removeprefix(MARK)
    near = get_close_matches(tag, list(places), n=1)
    return tuple(Label(where=places[name], text=f"`{name}` is a tag here; was `{tag}` meant?") for name in near)


def _names(file: TaskFile) -> set[str]:
    conditions = [c for node in file.graph.nodes for c in (node.success, node.failure)] + [file.graph.failure]
    return {name for condition in conditions if condition is not None for name in condition.objects()}


def named_objects(program: SceneProgram) -> SceneFacts:
    """The placed objects of a program with their tags; shapes are not known before assets are bound."""
    tags = {thing.id: (*thing.semantic_tags, *((thing.role,) if thing.role else ())) for thing in program.objects}
    names = {name: tags.get(node.object or name, ()) for name, node in program.layout.nodes.items()}
    names |= dict.fromkeys(WORLD_OBJECTS, ())
    point = np.zeros((1, 3))
    return SceneFacts({name: ObjectFacts(name, point, name, tags=tuple(words)) for name, words in names.items()})


def _rollouts(
    reader: MappingReader, assemblies: Mapping[str, object], findings: list[Diagnostic]
) -> tuple[RolloutOrder, ...]:
    orders: list[RolloutOrder] = []
    for number, item in enumerate(reader.list(ROLLOUTS)):
        if not isinstance(item, TreeMapping):
            findings.append(finding("pipeline/invalid-value", "a rollout is a mapping", where=item.at))
            continue
        rollout = MappingReader(item, "a rollout", findings, area="pipeline")
        rollout.refuse_other_keys(ROLLOUT_KEYS)
        env_ref = rollout.text("env_ref", needed=True)
        if env_ref is not None:
            _refers(item, "env_ref", env_ref, "assembly", assemblies, findings)
        modes = _modes(rollout, findings)
        teacher = _teacher(rollout, item.at, findings)
        if env_ref is not None and teacher is not None and modes:
            name = rollout.text("name") or f"{env_ref}-{number}"
            orders.append(
                RolloutOrder(name=name, env_ref=env_ref, modes=modes, teacher=teacher[0], settings=teacher[1])
            )
    return tuple(orders)


def _modes(rollout: MappingReader, findings: list[Diagnostic]) -> tuple[Mode, ...]:
    known = get_args(Mode)
    modes: list[Mode] = []
    for item in rollout.list("modes", needed=True):
        if isinstance(item, Scalar) and item.text in known:
            modes.append(cast(Mode, item.text))
        else:
            word = item.text if isinstance(item, Scalar) else ""
            headline = f"a mode is {' or '.join(known)}{did_you_mean(word, known)}"
            findings.append(finding("pipeline/invalid-value", headline, where=item.at, value=word or None))
    return tuple(modes)


def _teacher(rollout: MappingReader, at: Location, findings: list[Diagnostic]) -> tuple[str, dict[str, object]] | None:
    """Name and settings of what drives the robot: `planner: {Name: {...}}` or `teacher: {type: name, ...}`."""
    planner, teacher = rollout.entry("planner"), rollout.entry("teacher")
    if (planner is None) == (teacher is None):
        findings.append(
            finding("pipeline/missing-key", "a rollout needs `planner` or `teacher`, one of them", where=at)
        )
        return None
    if planner is not None:
        if isinstance(planner.value, TreeMapping) and len(planner.value.items) == 1:
            ((name, entry),) = planner.value.items.items()
            settings = plain(entry.value)
            return name, dict(settings) if isinstance(settings, dict) else {}
        rollout.wrong("planner", "takes one mapping, named by the planner", planner)
        return None
    block = rollout.mapping("teacher")
    if block is None:
        return None
    reader = MappingReader(block, "`teacher`", findings, area="pipeline")
    kind = reader.text("type", needed=True)
    return None if kind is None else (kind, {key: value for key, value in plain(block).items() if key != "type"})


def _report_unused(parts: Parts, assemblies: Mapping[str, AssemblyOrder | None], findings: list[Diagnostic]) -> None:
    """A warning for parts that no assembly names, where there are assemblies and all are known."""
    if not assemblies or not all(assemblies.values()):
        return
    orders = [order for order in assemblies.values() if order is not None]
    used = (
        {("scene", o.scene) for o in orders} | {("robot", o.robot) for o in orders} | {("task", o.task) for o in orders}
    )
    for (kind, name), where in parts.places.items():
        if (kind, name) not in used:
            findings.append(
                finding("pipeline/unused-order", f"no assembly uses the {kind} `{name}`", where=where, value=name)
            )
