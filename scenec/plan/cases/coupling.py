"""Partitions things into pools: groups of one owner, joined where cross-owner relations link them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import networkx as nx

from scenec.plan.cases.cross_owner_relations import cross_owner_relation
from scenec.solve.coupling import lifted, overlapping
from scenec.solve.model import SolverModel
from schemas.scene.geometry import BACKGROUND, SceneRelation


@dataclass(frozen=True)
class JointPool:
    """Things sampled jointly: `groups` of one owner each, and the cross-owner relations between them."""

    groups: tuple[tuple[str, ...], ...]
    rules: tuple[SceneRelation, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All of them, sorted."""
        return tuple(sorted(name for group in self.groups for name in group))


@dataclass(frozen=True)
class PoolPartition:
    """All pools, sorted by name; `frozen` things keep their solved pose; `model` has the relations lifted as far as
    possible.

    Pools are independent: their things are on different owners, or can never meet. Contents lie inside the footprint of
    their owner, so that it suffices to keep owners apart.
    """

    joint_pools: tuple[JointPool, ...]
    frozen: frozenset[str]
    model: SolverModel


def pools_of(base: SolverModel) -> PoolPartition:
    """Partition of the things of a model: those of one owner that may meet or that a relation links form one group.

    A relation across owners is lifted to the owners where that is stricter (contents of a tray are left of a box when
    the tray is). Otherwise the groups of all things that it depends on form one pool. Chains of owners in a robot's
    reach are frozen.
    """
    model = replace(base, rules=tuple(lifted(base, rule) for rule in base.rules))
    graph: nx.Graph[str] = nx.Graph()
    graph.add_nodes_from(model.things)
    graph.add_edges_from(overlapping(model))
    across = [rule for rule in model.rules if not model.in_one_frame(rule)]
    for rule in model.rules:
        if model.in_one_frame(rule):
            graph.add_edges_from(pairwise(rule.things))
    groups = sorted(tuple(sorted(part)) for part in nx.connected_components(graph))
    home = {name: k for k, names in enumerate(groups) for name in names}
    pools: nx.Graph[int] = nx.Graph()
    pools.add_nodes_from(range(len(groups)))
    links = [[home[name] for name in cross_owner_relation(model, rule).links] for rule in across]
    for numbers in links:
        pools.add_edges_from(pairwise(numbers))
    joint_pools = [
        JointPool(
            tuple(groups[k] for k in sorted(numbers)),
            tuple(rule for rule, at in zip(across, links, strict=True) if at[0] in numbers),
        )
        for numbers in nx.connected_components(pools)
    ]
    frozen: set[str] = set()
    if model.problem.reach is not None:
        for name in model.problem.reach.members:
            if model.things[name].parent != BACKGROUND:
                frozen |= set(model.chains[name])
    return PoolPartition(tuple(sorted(joint_pools, key=lambda pool: pool.names)), frozenset(frozen), model)
