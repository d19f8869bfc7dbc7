"""Relations that nothing fulfils, whatever else the program holds: the meaning of each may have a proof of its own."""

from __future__ import annotations

from scenec.ir.problem import Problem, Proof
from scenec.relations.table import RELATIONS


def impossible_relation(problem: Problem) -> Proof | None:
    """The first proof of a relation that it cannot hold; its theorem is in `scenec.relations`, in the file of its
    kind."""
    proofs = (RELATIONS[relation.kind].refuted(relation, problem) for relation in problem.relations)
    return next((proof for proof in proofs if proof is not None), None)
