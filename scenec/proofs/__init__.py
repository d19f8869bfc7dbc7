"""Arguments that there is no scene. Each is a function of the problem whose docstring states the theorem; none is ever
false, all are deterministic, and no proof says nothing about whether a scene exists.

    prove(problem)          cheap arguments first, then the complete one for few things
    prove_cheaply(problem)  milliseconds: what a solver asks before it searches
"""

from __future__ import annotations

from scenec.ir import Problem, Proof
from scenec.proofs.apart import near_and_far
from scenec.proofs.areas import more_area_than_there_is
from scenec.proofs.axes import too_long_along_an_axis
from scenec.proofs.exhaustive import no_arrangement
from scenec.proofs.fits import no_place_of_its_own
from scenec.proofs.owners import no_first_owner
from scenec.proofs.spots import more_things_than_spots

CHEAP = (
    no_first_owner,
    too_long_along_an_axis,
    near_and_far,
    no_place_of_its_own,
    more_things_than_spots,
    more_area_than_there_is,
)
__all__ = ["prove", "prove_cheaply"]


def prove_cheaply(problem: Problem) -> Proof | None:
    """The first cheap proof that there is no scene, or None."""
    for argument in CHEAP:
        proof = argument(problem)
        if proof is not None:
            return proof
    return None


def prove(problem: Problem, most_programs: int = 400) -> Proof | None:
    """The first proof that there is no scene, or None; the complete argument solves so many linear programs at most."""
    return prove_cheaply(problem) or no_arrangement(problem, most_programs)
