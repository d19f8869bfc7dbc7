"""Minimal sets of authored constraints that cannot hold together (QuickXplain, Junker 2004).

Constraints come first (relations, ranges, keep-outs, reach, clearance), with all things present. The things themselves
are the conflict only where they have no room without any of these. A conflict always rests on a proof; a search without
result is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scenec.ir.problem import Infeasible, Problem, Proof, Result, Solved
from scenec.ir.relaxed import nodes, relaxed, rules
from scenec.proofs import refutation
from source.tree import Path

Feasible = Callable[[Problem], Result]


@dataclass(frozen=True)
class Conflict:
    """Constraints, by path, that are proved to contradict one another. `minimal` only if for each of them a scene was
    found that keeps all the others."""

    paths: tuple[Path, ...]
    minimal: bool
    proof: Proof


def minimal_conflict(problem: Problem, feasible: Feasible) -> Conflict | None:
    """The conflict behind an infeasible problem; None when no proof of infeasibility is found.

    Parts are refuted by the argument that refuted the whole, which keeps this to milliseconds. Where the rest without
    one member turns out to be infeasible too, for another reason, that smaller conflict is followed instead.
    """
    refuted_by = refutation(problem)
    if refuted_by is None:
        return None
    proof, refuted = refuted_by
    authored = rules(problem)
    if (alone := refuted(relaxed(problem, authored))) is not None:
        problem, authored, proof = relaxed(problem, authored), nodes(problem), alone
    suspects = tuple(path for path in authored if _meant(path, proof.paths))
    rest = tuple(path for path in authored if path not in suspects)
    if refuted(relaxed(problem, rest)) is None:
        suspects, rest = authored, ()
    without = relaxed(problem, rest)
    paths = quick_xplain(suspects, lambda kept: refuted(relaxed(without, set(suspects) - set(kept))) is not None)
    core = relaxed(without, set(suspects) - set(paths))
    minimal = True
    for path in paths:
        result = feasible(relaxed(core, {path}))
        if isinstance(result, Infeasible):
            smaller = minimal_conflict(relaxed(core, {path}), feasible)
            if smaller is not None:
                return smaller
        minimal &= isinstance(result, Solved)
    return Conflict(paths, minimal, refuted(core) or proof)


def quick_xplain(paths: tuple[Path, ...], contradict: Callable[[tuple[Path, ...]], bool]) -> tuple[Path, ...]:
    """A subset for which `contradict` holds although it holds for no proper part of it (Junker 2004).

    It must hold for the whole of `paths`. Earlier paths are preferred to later ones.
    """

    def explain(paths_kept: tuple[Path, ...], added: bool, open_paths: tuple[Path, ...]) -> tuple[Path, ...]:
        if added and contradict(paths_kept):
            return ()
        if len(open_paths) == 1:
            return open_paths
        half = len(open_paths) // 2
        first, second = open_paths[:half], open_paths[half:]
        from_second = explain((*paths_kept, *first), bool(first), second)
        return (*explain((*paths_kept, *from_second), bool(from_second), first), *from_second)

    return () if not paths or contradict(()) else explain((), False, paths)


def _meant(path: Path, named: tuple[Path, ...]) -> bool:
    """Whether a path, or one above it, is named."""
    return any(path[: len(other)] == other for other in named)
