"""Whatever is drawn from the cells of a case is a valid scene: laws over random problems, judged by the checker."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.scenes.workload import workload
from scenec.check.judge_scene import violations
from scenec.ir.problem import Problem, Solved
from scenec.plan.document import plan_text
from scenec.solve import solve
from schemas.scene.runtime_plan import RuntimePlan
from tests.support.plan.draws import draws, plan_of
from tests.support.scene.random_problems import mixed_problem, random_problem, tray_problem, word_problem


def solved(problem) -> Solved:
    result = solve(problem, 0)
    assert isinstance(result, Solved)
    return result


@pytest.mark.parametrize("seed", range(40))
def test_draws_from_tight_problems_are_valid(seed: int):
    """Boxes of whole centimetres that touch each other, ranges of no width, keep-outs, reach, every relation."""
    problem = random_problem(seed)
    result = solve(problem, 0)
    if isinstance(result, Solved):
        plan = plan_of(problem, result)
        for placements in draws(plan, plan.combinations[0], np.random.default_rng(seed), 10):
            assert not violations(problem, placements)


@pytest.mark.parametrize("kind", ["above", "surrounding", "in_line"])
def test_draws_from_small_problems_of_a_word_are_valid(kind: str):
    """Heights, angles about a centre and steps in a line hold for all poses of a cell at once."""
    plans = 0
    for seed in range(25):
        problem = word_problem(kind, seed)
        result = solve(problem, 0, budget=1000)
        if isinstance(result, Solved):
            plan, plans = plan_of(problem, result), plans + 1
            for placements in draws(plan, plan.combinations[0], np.random.default_rng(seed), 10):
                assert not violations(problem, placements), seed
    assert plans >= 5


@pytest.mark.parametrize(
    ("made", "seed", "count"),
    [*((mixed_problem, seed, 20) for seed in range(6)), *((tray_problem, seed, 10) for seed in range(4))],
)
def test_draws_from_scenes_with_trays_are_valid(made: Callable[[int], Problem], seed: int, count: int):
    """Boxes at free headings on a table and on trays that move and turn; relations hold across trays too."""
    problem = made(seed)
    plan = plan_of(problem, solved(problem))
    for placements in draws(plan, plan.combinations[0], np.random.default_rng(seed), count):
        assert not violations(problem, placements)


def test_the_workload_has_many_cases_with_room_to_turn():
    problem = workload(20, 0)
    plan = plan_of(problem, solved(problem))
    (pool,) = plan.combinations[0].pools
    assert len(pool.cases) >= 60
    turns = [sum(b - a for a, b in yaws) * 1e-6 for case in pool.cases for yaws in case.yaws_urad]
    assert np.median(turns) > 0.3
    for placements in draws(plan, plan.combinations[0], np.random.default_rng(1), 40):
        assert not violations(problem, placements)


def test_the_same_seed_gives_the_same_bytes_whatever_the_order_of_objects():
    problem = workload(6, 1)
    result = solved(problem)
    text = plan_text(plan_of(problem, result))
    assert text == plan_text(plan_of(replace(problem, things=problem.things[::-1]), result))
    assert text != plan_text(plan_of(problem, result, seed=1))


def test_one_line_for_each_case():
    problem = workload(5, 0)
    plan = plan_of(problem, solved(problem))
    text = plan_text(plan)
    assert sum('"cells_um"' in line for line in text.splitlines()) == len(plan.combinations[0].pools[0].cases)
    assert RuntimePlan.model_validate_json(text) == plan


def test_a_mirrored_program_is_served_as_well():
    problem = workload(8, 2)
    mirrored = replace(
        problem, relations=tuple(replace(r, direction=(-r.direction[0], r.direction[1])) for r in problem.relations)
    )
    plan = plan_of(mirrored, solved(mirrored))
    for placements in draws(plan, plan.combinations[0], np.random.default_rng(2), 40):
        assert not violations(mirrored, placements)


def test_more_diversity_makes_more_cases():
    problem = workload(5, 0)
    result = solved(problem)
    few, many = (len(plan_of(problem, result, diversity=d).combinations[0].pools[0].cases) for d in (0.1, 0.5))
    assert many > 2 * few
