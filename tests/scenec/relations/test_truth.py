"""The solver and the proofs against the truth on a grid, for words of which it knows the meaning a third time."""

from __future__ import annotations

from collections import Counter

import pytest

from scenec.check.judge_scene import violations
from scenec.ir.problem import Infeasible, Problem, Solved
from scenec.proofs import prove
from scenec.solve import solve
from tests.support.scene.random_problems import word_problem
from tests.support.scene.truth import truth

SEEDS = 25


def steps_m(case: Problem) -> tuple[float, ...]:
    """Steps of the grids: four things have too many poses on the finer one."""
    return (0.02, 0.01) if len(case.things) < 4 else (0.02,)


@pytest.mark.parametrize("kind", ["above", "surrounding", "in_line"])
def test_what_the_grid_has_is_solved_and_what_it_excludes_is_not(kind: str) -> None:
    counts: Counter[tuple[str, str]] = Counter()
    for seed in range(SEEDS):
        case = word_problem(kind, seed)
        answer, result = truth(case, steps_m(case)), solve(case, budget=2000)
        counts[answer, type(result).__name__] += 1
        if isinstance(result, Solved):
            assert answer != "no", seed
            assert list(violations(case, result.placements)) == [], seed
            assert prove(case) is None, seed
        assert answer != "yes" or isinstance(result, Solved), seed
    assert counts["yes", "Solved"] >= SEEDS // 5, counts
    assert counts["no", "Infeasible"], counts


@pytest.mark.parametrize("kind", ["above", "surrounding", "in_line"])
def test_no_proof_against_a_problem_that_has_a_scene(kind: str) -> None:
    for seed in range(SEEDS, 4 * SEEDS):
        case = word_problem(kind, seed)
        result = solve(case, budget=500)
        if isinstance(result, Infeasible):
            assert truth(case, steps_m(case)[:1]) != "yes", seed
