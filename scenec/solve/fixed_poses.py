"""Assigns things to fixed poses, each to one of its own, by maximum bipartite matching (Hopcroft and Karp 1973)."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx

from scenec.ir.problem import Placement
from scenec.solve.check import Assignment, fits_alone
from scenec.solve.model import SolverModel
from scenec.solve.search import fixed_pose_placements


def match_fixed_poses(model: SolverModel, names: Sequence[str], standing: Assignment) -> dict[str, Placement]:
    """A fixed pose for as many of `names` as can have one of their own; other clashes are not considered."""
    # Nodes are whole numbers, things first: the matching iterates over sets, where the order of strings is random.
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(range(len(names)))
    nodes: dict[tuple[object, ...], int] = {}
    offers: dict[tuple[int, int], Placement] = {}
    for k, name in enumerate(names):
        thing = model.things[name]
        for number, fixed_pose in enumerate(thing.domain.fixed_poses):
            fitting = [p for p in fixed_pose_placements(model, thing, number) if fits_alone(model, model.put(name, p))]
            if fitting:
                where = (thing.parent, thing.place.name, fixed_pose.x_m, fixed_pose.y_m, fixed_pose.z_m)
                node = nodes.setdefault(where, len(names) + len(nodes))
                graph.add_edge(k, node)
                offers.setdefault((k, node), fitting[0])
    matching = nx.bipartite.hopcroft_karp_matching(graph, range(len(names)))
    return {name: offers[k, matching[k]] for k, name in enumerate(names) if k in matching}
