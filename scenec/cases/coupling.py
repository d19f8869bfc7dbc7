"""Which things must be chosen together: pools, and things that a relation across owners freezes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import networkx as nx

from scenec.ir import WORLD_PARENT
from scenec.solve.coupling import lifted, overlapping
from scenec.solve.model import Model


@dataclass(frozen=True)
class Pools:
    """`names` of each pool, by their first; `frozen` things keep the solved pose; `model` has rules as pools keep them.

    Pools are independent: their things stand on different owners, or can never meet. What stands on an owner is inside
    its footprint, so that owners apart are enough.
    """

    names: tuple[tuple[str, ...], ...]
    frozen: frozenset[str]
    model: Model


def pools_of(base: Model) -> Pools:
    """Things of one owner that may meet or that a relation ties are one pool.

    A relation across owners is lifted to these where that is stricter (what stands on a tray is left of a box when the
    tray is). Otherwise all that its truth depends on is frozen; so is a chain of owners within a robot's reach.
    """
    model = replace(base, rules=tuple(lifted(base, rule) for rule in base.rules))
    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from(model.things)
    graph.add_edges_from(overlapping(model))
    frozen: set[str] = set()
    for rule in model.rules:
        if model.in_one_frame(rule):
            graph.add_edges_from(pairwise(rule.things))
        else:
            frozen |= model.depends_on(rule)
    if model.problem.reach is not None:
        for name in model.problem.reach.members:
            if model.things[name].parent != WORLD_PARENT:
                frozen |= set(model.chains[name])
    found = sorted(tuple(sorted(part)) for part in nx.connected_components(graph))
    return Pools(tuple(found), frozenset(frozen), model)
