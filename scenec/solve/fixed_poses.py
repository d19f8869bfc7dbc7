"""Things with poses written down: each takes a spot of its own by a bipartite matching (Hopcroft and Karp 1973)."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx

from scenec.ir.problem import Placement
from scenec.solve.check import Assignment, fits_alone
from scenec.solve.model import Model
from scenec.solve.search import spot_placements


def match_spots(model: Model, names: Sequence[str], standing: Assignment) -> dict[str, Placement]:
    """A spot for as many of `names` as can have one where no two share a spot; other clashes are not looked at."""
    graph: nx.Graph[tuple[str, object]] = nx.Graph()
    offers: dict[tuple[str, object], Placement] = {}
    tops = [("thing", name) for name in names]
    graph.add_nodes_from(tops)
    for name in names:
        thing = model.things[name]
        for number, spot in enumerate(thing.domain.spots):
            fitting = [p for p in spot_placements(model, thing, number) if fits_alone(model, model.put(name, p))]
            if fitting:
                where = (thing.parent, thing.place.name, spot.x_m, spot.y_m, spot.z_m)
                graph.add_edge(("thing", name), ("spot", where))
                offers.setdefault((name, where), fitting[0])
    matching = nx.bipartite.hopcroft_karp_matching(graph, tops)
    return {name: offers[name, matching["thing", name][1]] for name in names if ("thing", name) in matching}
