"""Ownership proofs: an owner is missing, or owners form a cycle. Nothing can be placed before its owner."""

from __future__ import annotations

import networkx as nx

from scenec.ir.problem import Problem, Proof
from schemas.scene.geometry import BACKGROUND


def no_first_owner(problem: Problem) -> Proof | None:
    """A proof when the chain of owners of some thing does not end in the background."""
    by_name = {thing.name: thing for thing in problem.things}
    for thing in problem.things:
        if thing.parent != BACKGROUND and thing.parent not in by_name:
            text = f"{thing.name} stands on {thing.parent}, which is not in the scene"
            return Proof("missing-anchor", text, 0.0, 1.0, "owners", (thing.path,))
    carried = [(thing.name, thing.parent) for thing in problem.things if thing.parent != BACKGROUND]
    if not carried:
        return None
    try:
        circle = [one for one, _ in nx.find_cycle(nx.DiGraph(carried))]
    except nx.NetworkXNoCycle:
        return None
    text = f"{' stands on '.join([*circle, circle[0]])}"
    return Proof("owner-cycle", text, float(len(circle)), 0.0, "owners", tuple(by_name[n].path for n in circle))
