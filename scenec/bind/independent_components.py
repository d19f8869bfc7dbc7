"""Independent components of a scene over all its variants: sets of things that share nothing and are solved
separately."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import networkx as nx
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from scenec.ir.problem import Problem
from scenec.solve.coupling import boxes_may_meet, footprint_bounds, heights
from scenec.solve.keep_clear import beside
from scenec.solve.model import SolverModel, model_of
from schemas.scene.geometry import BACKGROUND


def independent_components(problems: Sequence[Problem]) -> tuple[tuple[str, ...], ...]:
    """Names of things in the order of the program, by independent component. `problems` must hold each thing in each of
    its geometries on each background. A whole scene exists if and only if each component has one.

    One component holds a thing and all it carries, things that any relation links or that must leave its swept spaces
    free, and things on the background whose
    bounding boxes, over all their geometries and poses, come closer than the clearance. Unlike the components of one
    problem, these are not separated by coordinates, which would depend on the geometry of the other side.
    """
    first = problems[0]
    graph: nx.Graph[str] = nx.Graph()
    by_path: dict[object, str] = {}
    for thing in first.things:
        graph.add_edge(by_path.setdefault(thing.path, thing.name), thing.name)
        if thing.parent != BACKGROUND:
            graph.add_edge(thing.parent, thing.name)
    for rule in first.relations:
        tied = (*rule.things, rule.frame)
        graph.add_edges_from(pairwise(name for name in tied if name != BACKGROUND))
    by_name = {thing.name: thing for thing in first.things}
    for space in first.keep_clear:
        graph.add_edges_from((space.owner, other) for other in beside(space, by_name))
    roots = [thing.name for thing in first.things if thing.parent == BACKGROUND]
    if roots:
        models = [model_of(problem) for problem in problems]
        low, high = (
            ends([[_room(model, name)[k] for name in roots] for model in models], axis=0)
            for k, ends in ((0, np.min), (1, np.max))
        )
        near = boxes_may_meet(low, high, first.clearance_m)
        labels = connected_components(csr_array(near), directed=False)[1].tolist()
        leader: dict[int, str] = {}
        for name, label in zip(roots, labels, strict=True):
            graph.add_edge(leader.setdefault(label, name), name)
    order = {thing.name: k for k, thing in enumerate(first.things)}
    components = (sorted(part, key=lambda name: order[name]) for part in nx.connected_components(graph))
    return tuple(sorted((tuple(part) for part in components), key=lambda part: order[part[0]]))


def _room(model: SolverModel, name: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    # Bounding box (low, high) in the frame of the background of a thing with all it carries, over all its poses.
    x0, y0, x1, y1 = footprint_bounds(model, name)
    low, high = heights(model, name)
    if name in model.carriers:  # what it carries may vary as well
        site = model.site(model.things[name])
        high = max(high, site.base_P_m + site.top_m)
    return (x0, y0, low), (x1, y1, high)
