"""A task: nodes with conditions, and edges from each node to those that wait for it (the paper's Task DAG)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from graphlib import CycleError, TopologicalSorter

from task.predicates.protocol import Predicate

WHOLE = 10  # points of a task


class InvalidGraph(Exception):
    """Nodes and edges that are no task; the text names every fault, a line each."""


@dataclass(frozen=True)
class TaskNode:
    """One stage.

    success       holds when the stage is reached; it counts from the frame on in which all predecessors are done.
    failure       ends the task with a failure when it holds while the node is active.
    timeout_s     most seconds from activation to completion.
    points        share of the task's ten points.
    true_at_reset whether `success` may hold in the first frame; else a node that is active then fails the task.
    must_last     whether `success` has to go on holding until the task is done; undone, it fails the task.
    """

    node_id: str
    success: Predicate
    failure: Predicate | None = None
    timeout_s: float | None = None
    points: Fraction = Fraction(1)
    true_at_reset: bool = False
    must_last: bool = False
    instruction: str = ""


@dataclass(frozen=True)
class TaskGraph:
    """Nodes by id and edges (before, after). `failure` and `time_limit_s` hold for the whole task.

    Raises InvalidGraph.
    """

    name: str
    nodes: tuple[TaskNode, ...]
    edges: tuple[tuple[str, str], ...] = ()
    failure: Predicate | None = None
    time_limit_s: float | None = None
    instruction: str = ""
    by_id: Mapping[str, TaskNode] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "by_id", {node.node_id: node for node in self.nodes})
        if faults := graph_faults([node.node_id for node in self.nodes], self.edges):
            raise InvalidGraph("\n".join(faults))

    @cached_property
    def predecessors(self) -> Mapping[str, tuple[str, ...]]:
        """For each node those that it waits for."""
        return {v: tuple(sorted({a for a, b in self.edges if b == v})) for v in self.by_id}

    @cached_property
    def order(self) -> tuple[str, ...]:
        """All nodes, each after those it waits for: by the length of the longest way from a root, then by id."""
        depth: dict[str, int] = {}
        for v in TopologicalSorter(self.predecessors).static_order():
            depth[v] = 1 + max((depth[u] for u in self.predecessors[v]), default=-1)
        return tuple(sorted(depth, key=lambda v: (depth[v], v)))

    @cached_property
    def roots(self) -> tuple[str, ...]:
        """Nodes that wait for none, in order."""
        return tuple(v for v in self.order if not self.predecessors[v])

    @cached_property
    def sinks(self) -> tuple[str, ...]:
        """Nodes that none waits for, in order."""
        waited_for = {a for a, _ in self.edges}
        return tuple(v for v in self.order if v not in waited_for)

    @cached_property
    def weights(self) -> Mapping[str, Fraction]:
        """Points of each node, scaled so that they are ten together, exactly."""
        total = sum((node.points for node in self.nodes), start=Fraction(0))
        return {node.node_id: node.points * WHOLE / total for node in self.nodes}


def graph_faults(nodes: list[str], edges: tuple[tuple[str, str], ...]) -> list[str]:
    """What is wrong with ids and edges, a line each."""
    faults = [f"the node `{v}` occurs {nodes.count(v)} times" for v in sorted(set(nodes)) if nodes.count(v) > 1]
    if not nodes:
        faults.append("a task needs a node")
    for a, b in edges:
        faults += [f"the edge {a} -> {b} names `{v}`, which is no node" for v in (a, b) if v not in nodes]
    if not faults:
        try:
            waits = TopologicalSorter({v: [a for a, b in edges if b == v] for v in nodes})
            waits.prepare()
        except CycleError as circle:
            faults.append(f"nodes wait for each other: {' -> '.join(circle.args[1])}")
    return faults
