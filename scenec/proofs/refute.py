"""Runs the arguments of this folder in turn: cheap ones first, then the complete one for few things."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from scenec.ir.problem import Problem, Proof, is_round
from scenec.ir.relaxed import relaxed
from scenec.proofs.alone import impossible_relation
from scenec.proofs.apart import near_and_far
from scenec.proofs.areas import more_area_than_there_is
from scenec.proofs.axes import too_long_along_an_axis
from scenec.proofs.exhaustive import no_arrangement
from scenec.proofs.fits import no_place_of_its_own
from scenec.proofs.fixed_poses import more_things_than_fixed_poses
from scenec.proofs.owners import no_first_owner

Argument = Callable[[Problem], Proof | None]
CHEAP: tuple[Argument, ...] = (
    no_first_owner,
    too_long_along_an_axis,
    near_and_far,
    impossible_relation,
    no_place_of_its_own,
    more_things_than_fixed_poses,
    more_area_than_there_is,
)
MOST_PROGRAMS = 400


def prove_cheaply(problem: Problem) -> Proof | None:
    """The first cheap proof that there is no scene, or None."""
    proved = refutation(problem, most_programs=0)
    return proved and proved[0]


def prove(problem: Problem, most_programs: int = MOST_PROGRAMS) -> Proof | None:
    """The first proof that there is no scene, or None; the complete argument solves so many linear programs at most."""
    proved = refutation(problem, most_programs)
    return proved and proved[0]


def refutation(problem: Problem, most_programs: int = MOST_PROGRAMS) -> tuple[Proof, Argument] | None:
    """The first proof, and the argument that gave it; without programs the cheap arguments only."""
    complete = partial(no_arrangement, most_programs=most_programs)
    for argument in (*CHEAP, complete) if most_programs else CHEAP:
        without = partial(_of_what_stands, argument)
        proof = without(problem)
        if proof is not None:
            return proof, without
    return None


def _of_what_stands(argument: Argument, problem: Problem) -> Proof | None:
    # In a round bowl things lean on the wall and on each other; what cannot stand there may well lie there.
    leaning = {t.path for t in problem.things if is_round(t.place) and not t.domain.fixed_poses}
    return argument(relaxed(problem, leaning) if leaning else problem)
