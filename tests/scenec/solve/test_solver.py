"""The solver on problems built by hand, judged by the independent checker."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.scenes.workload import workload
from scenec.check.judge_scene import violations
from scenec.ir.problem import Problem, Solved
from scenec.solve import solve


def solved(problem: Problem, seed: int = 0, **options) -> Solved:
    result = solve(problem, seed, **options)
    assert isinstance(result, Solved), result
    assert set(result.placements) == {thing.name for thing in problem.things}
    assert violations(problem, result.placements) == ()
    return result


@pytest.mark.parametrize(("n", "seed"), [(1, 0), (5, 0), (30, 1), (60, 0), (80, 2)])
def test_boxes_on_a_table_with_relations(n: int, seed: int):
    solved(workload(n, seed))


def test_the_same_program_and_seed_give_the_same_scene():
    assert solve(workload(20, 0), 3) == solve(workload(20, 0), 3)


def test_the_order_of_objects_does_not_matter():
    problem = workload(20, 1)
    turned_round = replace(problem, things=problem.things[::-1], relations=problem.relations[::-1])
    assert solved(problem).placements == solved(turned_round).placements
