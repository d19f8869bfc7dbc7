"""Contradiction of `near` and `far_from`.

Theorem (triangle inequality): the distance of two footprints is at most the sum of the distances along a path of
`near`, plus the diameters of the footprints in between.
"""

from __future__ import annotations

from itertools import pairwise

import networkx as nx
import numpy as np
from scipy.spatial.distance import pdist

from scenec.ir.problem import Problem, Proof, Thing
from scenec.proofs.outlines import OUTLINE_SLACK_M, hull, resting_orientations
from scenec.proofs.places import area_hull
from scenec.relations.table import RELATIONS
from schemas.arrays import FloatArray
from schemas.scene.geometry import SceneRelation


def near_and_far(problem: Problem) -> Proof | None:
    """A proof for the first `far_from` larger than a chain of `near`, or the diameter of the support, allows."""
    by_name = {thing.name: thing for thing in problem.things}
    graph = nx.Graph()
    for relation in problem.relations:
        if (most_m := RELATIONS[relation.kind].most_distance_m(relation)) is not None:
            one, two = relation.things
            old = graph.get_edge_data(one, two, {"gap": np.inf})
            if most_m < old["gap"]:
                graph.add_edge(one, two, gap=most_m, path=relation.path)
    for relation in problem.relations:
        if (least_m := RELATIONS[relation.kind].least_distance_m(relation)) is not None:
            proof = _by_chain(relation, least_m, graph, by_name) or _by_place(relation, least_m, by_name)
            if proof is not None:
                return proof
    return None


def _by_chain(relation: SceneRelation, least_m: float, graph: nx.Graph, by_name: dict[str, Thing]) -> Proof | None:
    one, two = relation.things[:2]
    if one not in graph or two not in graph or not nx.has_path(graph, one, two):
        return None
    widest = {name: _diameter(by_name[name]) for name in graph.nodes}

    def length(u: str, v: str, edge: dict) -> float:
        return edge["gap"] + (widest[v] if v != two else 0.0)

    chain = nx.shortest_path(graph.to_directed(), one, two, weight=length)
    steps = list(pairwise(chain))
    most = sum(length(u, v, graph.edges[u, v]) for u, v in steps)
    if least_m <= most + len(steps) * OUTLINE_SLACK_M:
        return None
    paths = (relation.path, *(graph.edges[u, v]["path"] for u, v in steps))
    through = ", ".join(chain)
    text = f"{one} must be {least_m:.4g} m from {two}, but near: {through} allow {most:.4g} m at most"
    return Proof("empty-domain", text, least_m, most, "m", paths)


def _by_place(relation: SceneRelation, least_m: float, by_name: dict[str, Thing]) -> Proof | None:
    one, two = (by_name[name] for name in relation.things[:2])
    if (one.parent, one.place.name) != (two.parent, two.place.name) or one.domain.fixed_poses or two.domain.fixed_poses:
        return None
    # Points of both footprints lie on the place, so that their distance is at most its diameter.
    most = _widest(area_hull(one.place))
    if least_m <= most + OUTLINE_SLACK_M:
        return None
    text = f"{one.name} must be {least_m:.4g} m from {two.name}; {one.place.name} is {most:.4g} m across"
    return Proof("empty-domain", text, least_m, most, "m", (relation.path,))


def _diameter(thing: Thing) -> float:
    return max(_widest(hull(stance.prisms)) for stance in resting_orientations(thing))


def _widest(ring: FloatArray) -> float:
    return float(pdist(ring).max())
