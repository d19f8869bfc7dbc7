"""Typed interaction graph of a problem: support, containment, possible overlap, relations, and joint components.

Nodes are things and groups. A component is a set of things that must be solved jointly: their footprints, over all
that their domains allow and grown by the clearance, may meet, or an undirected relation ties them. Directional
relations order the components but do not merge them.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Literal

import networkx as nx

from scenec.ir.problem import Problem
from scenec.relations.table import RELATIONS
from scenec.solve.coupling import components_of, overlapping
from scenec.solve.model import model_of
from schemas.scene.geometry import BACKGROUND
from source.tree import Path

EdgeKind = Literal["support", "containment", "overlap", "relation", "group"]
STYLE: dict[EdgeKind, str] = {
    "support": "color=black",
    "containment": "color=black, style=bold",
    "overlap": "color=gray60, dir=none, style=dashed",
    "relation": "color=firebrick",
    "group": "color=steelblue, style=dotted",
}


@dataclass(frozen=True)
class GraphNode:
    """A thing, a group or the background; `path` in the program."""

    name: str
    kind: Literal["thing", "group", "background"]
    path: Path = ()


@dataclass(frozen=True)
class GraphEdge:
    """A directed edge: `source` carries, may overlap, is related to, or groups `target`."""

    source: str
    target: str
    kind: EdgeKind
    label: str = ""
    path: Path = ()


@dataclass(frozen=True)
class InteractionGraph:
    """`components` are names of things solved together; `schedule` numbers them so that owners come first."""

    nodes: tuple[GraphNode, ...]
    edges: tuple[GraphEdge, ...]
    components: tuple[tuple[str, ...], ...]
    schedule: tuple[int, ...]

    def dot(self) -> str:
        """The graph in Graphviz' language: a box around each component that has several members."""
        lines = ["digraph scene {", "  rankdir=TB; node [shape=box, fontname=Helvetica];"]
        for number, members in enumerate(self.components):
            if len(members) > 1:
                names = "; ".join(_quoted(_key("thing", name)) for name in members)
                lines.append(f"  subgraph cluster_{number} {{ color=gray80; {names} }}")
        for node in self.nodes:
            shape = {"thing": "box", "group": "folder", "background": "house"}[node.kind]
            lines.append(f"  {_quoted(_key(node.kind, node.name))} [label={_quoted(node.name)}, shape={shape}];")
        for edge in self.edges:
            source = _key("group" if edge.kind == "group" else "thing", edge.source)
            label = f", label={_quoted(edge.label)}" if edge.label else ""
            lines.append(f"  {_quoted(source)} -> {_quoted(_key('thing', edge.target))} [{STYLE[edge.kind]}{label}];")
        return "\n".join([*lines, "}", ""])

    def json(self) -> str:
        """The graph as JSON text: nodes, edges, components, schedule."""
        return json.dumps(
            {
                "nodes": [{"name": n.name, "kind": n.kind, "path": list(n.path)} for n in self.nodes],
                "edges": [
                    {"source": e.source, "target": e.target, "kind": e.kind, "label": e.label, "path": list(e.path)}
                    for e in self.edges
                ],
                "components": [list(members) for members in self.components],
                "schedule": list(self.schedule),
            },
            indent=1,
        )


def interaction_graph(problem: Problem) -> InteractionGraph:
    """The graph of a problem, components as the solver takes them. Nodes and components are in the order of names."""
    model = model_of(problem)
    things = model.things
    groups = sorted({thing.group for thing in things.values() if thing.group is not None})
    nodes = [GraphNode(BACKGROUND, "background")]
    nodes += [GraphNode(thing.name, "thing", thing.path) for thing in things.values()]
    nodes += [GraphNode(group, "group", ("layout", "groups", group)) for group in groups]
    edges = [
        GraphEdge(t.parent, t.name, "containment" if t.place.is_volume else "support", t.place.name, t.path)
        for t in things.values()
    ]
    edges += [GraphEdge(t.group, t.name, "group", path=t.path) for t in things.values() if t.group is not None]
    edges += [GraphEdge(a, b, "overlap") for a, b in overlapping(model)]
    for rule in problem.relations:
        first, *rest = rule.things
        edges += [GraphEdge(first, other, "relation", rule.word or rule.kind, rule.path) for other in rest]
    components = components_of(model)
    return InteractionGraph(tuple(nodes), tuple(edges), components, schedule_of(components, problem))


def schedule_of(components: tuple[tuple[str, ...], ...], problem: Problem) -> tuple[int, ...]:
    """Numbers of components, owners of a component's places first, then by directional relations where they agree."""
    home = {name: k for k, members in enumerate(components) for name in members}
    order: nx.DiGraph[int] = nx.DiGraph()
    order.add_nodes_from(range(len(components)))
    owners = [(home[t.parent], home[t.name]) for t in problem.things if t.parent in home]
    relations = [(home[a], home[b]) for r in problem.relations if RELATIONS[r.kind].separable for a, b in [r.things]]
    for source, target in [*owners, *relations]:
        if source != target and not nx.has_path(order, target, source):
            order.add_edge(source, target)
    return tuple(nx.lexicographical_topological_sort(order))


def _key(kind: str, name: str) -> str:
    return f"group {name}" if kind == "group" else name


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
