"""Binds the roles of a task (`@tag`) to objects of a scene, and finds what the scene cannot give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

from schemas.task.scene_facts import SceneFacts
from task.graph import TaskGraph
from task.predicates.combine.counted import MEMBER
from task.predicates.protocol import ROLE, Predicate, items

MARK = "@"
FaultKind = Literal["unbound", "ambiguous"]


class RoleFault(NamedTuple):
    """A name of a node (empty for the task) that means no object, or too many; `candidates` are what it could be."""

    node: str
    kind: FaultKind
    name: str
    candidates: tuple[str, ...]


def bind_roles(
    graph: TaskGraph, scene: SceneFacts, roles: Mapping[str, Sequence[str]]
) -> tuple[TaskGraph, tuple[RoleFault, ...]]:
    """The graph with names of objects in place of roles, and what could not be bound.

    A role means the objects that `roles` names for it, else those that the scene tags with it. Where a condition takes
    several objects it means all of them, in order of their names; where it takes one there must be one.
    """
    faults: list[RoleFault] = []

    def bound(predicate: Predicate | None, node: str) -> Predicate | None:
        return None if predicate is None else _bound(predicate, node, scene, roles, faults)

    nodes = tuple(
        replace(
            node,
            success=bound(node.success, node.node_id) or node.success,
            failure=bound(node.failure, node.node_id),
        )
        for node in graph.nodes
    )
    bound_graph = replace(graph, nodes=nodes, failure=bound(graph.failure, ""))
    first: dict[tuple[str, str], RoleFault] = {}
    for fault in faults:
        first.setdefault((fault.kind, fault.name), fault)
    return bound_graph, tuple(first.values())


def _bound(
    predicate: Predicate, node: str, scene: SceneFacts, roles: Mapping[str, Sequence[str]], faults: list[RoleFault]
) -> Predicate:
    changes: dict[str, object] = {}
    for name, field in type(predicate).model_fields.items():
        value = getattr(predicate, name)
        after: list[object] = []
        for item in items(value):
            if isinstance(item, Predicate):
                after.append(_bound(item, node, scene, roles, faults))
            elif ROLE in field.metadata and isinstance(item, str) and item != MEMBER:
                after += _objects(item, node, isinstance(value, tuple), scene, roles, faults)
            else:
                after.append(item)
        changes[name] = tuple(after) if isinstance(value, tuple) else after[0]
    return predicate.model_copy(update=changes)


def _objects(
    name: str,
    node: str,
    several: bool,
    scene: SceneFacts,
    roles: Mapping[str, Sequence[str]],
    faults: list[RoleFault],
) -> tuple[str, ...]:
    if not name.startswith(MARK):
        if name not in scene.objects:
            faults.append(RoleFault(node, "unbound", name, tuple(sorted(scene.objects))))
        return (name,)
    role = name.removeprefix(MARK)
    players = tuple(roles[role]) if role in roles else scene.tagged(role)
    absent = [each for each in players if each not in scene.objects]
    if absent or not players:
        tags = sorted({tag for facts in scene.objects.values() for tag in facts.tags} | set(roles))
        candidates = tuple(sorted(scene.objects)) if absent else tuple(f"@{tag}" for tag in tags)
        faults.append(RoleFault(node, "unbound", absent[0] if absent else name, candidates))
        return (name,)
    if len(players) > 1 and not several:
        faults.append(RoleFault(node, "ambiguous", name, players))
        return (name,)
    return players
