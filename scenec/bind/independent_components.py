"""Things that share nothing with the others whatever the variants choose: each such set has verdicts of its own."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import networkx as nx
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from scenec.ir.problem import WORLD_PARENT, Problem
from scenec.solve.coupling import footprint_bounds, heights, meeting
from scenec.solve.model import Model, model_of


def islands(problems: Sequence[Problem]) -> tuple[tuple[str, ...], ...]:
    """Names of things in the order of the program, in sets that share nothing: `problems` hold each thing in each of
    its geometries on each background. A whole scene exists if and only if each island has one.

    On one island are a thing and all it carries, things that any relation ties, and things on the background whose
    room, over all that they may be, comes closer than the clearance. Unlike components of one problem, islands are
    not kept apart by separating coordinates: these would depend on what the other side is.
    """
    first = problems[0]
    graph: nx.Graph[str] = nx.Graph()
    by_path: dict[object, str] = {}
    for thing in first.things:
        graph.add_edge(by_path.setdefault(thing.path, thing.name), thing.name)
        if thing.parent != WORLD_PARENT:
            graph.add_edge(thing.parent, thing.name)
    for rule in first.relations:
        tied = (*rule.things, rule.frame)
        graph.add_edges_from(pairwise(name for name in tied if name != WORLD_PARENT))
    roots = [thing.name for thing in first.things if thing.parent == WORLD_PARENT]
    if roots:
        models = [model_of(problem) for problem in problems]
        low, high = (
            ends([[_room(model, name)[k] for name in roots] for model in models], axis=0)
            for k, ends in ((0, np.min), (1, np.max))
        )
        near = meeting(low, high, first.clearance_m)
        labels = connected_components(csr_array(near), directed=False)[1].tolist()
        leader: dict[int, str] = {}
        for name, label in zip(roots, labels, strict=True):
            graph.add_edge(leader.setdefault(label, name), name)
    order = {thing.name: k for k, thing in enumerate(first.things)}
    found = (sorted(part, key=lambda name: order[name]) for part in nx.connected_components(graph))
    return tuple(sorted((tuple(part) for part in found), key=lambda part: order[part[0]]))


def _room(model: Model, name: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    # Lowest and highest x, y, z in the frame of the background that a thing with all it carries may take.
    x0, y0, x1, y1 = footprint_bounds(model, name)
    low, high = heights(model, name)
    if name in model.carriers:  # what it carries may vary as well
        site = model.site(model.things[name])
        high = max(high, site.base_P_m + site.top_m)
    return (x0, y0, low), (x1, y1, high)
