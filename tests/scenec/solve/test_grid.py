"""The grid family spreads unrelated things with room over their place, and leaves all others to other families."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import box

from benchmarks.scenes.workload import workload
from scenec.check.judge_scene import violations
from scenec.ir.problem import Solved
from scenec.solve import solve
from scenec.solve.grid import spread_grid
from scenec.solve.model import model_of
from schemas.scene.geometry import KeepOutVolume, SceneRelation


def loose(n: int, seed: int):
    return replace(workload(n, seed), relations=())


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 16), st.integers(0, 99), st.booleans())
def test_whatever_the_grid_seats_is_a_valid_scene(n: int, seed: int, kept_out: bool):
    problem = loose(n, seed)
    if kept_out:
        surface = problem.things[0].place
        assert not surface.is_volume
        rule = KeepOutVolume("background", surface, box(-0.2, -0.4, 0.1, 0.1), np.inf, ("keep_outs", 0))
        problem = replace(problem, keep_outs=(rule,))
    found = spread_grid(model_of(problem), [thing.name for thing in problem.things], {}, seed)
    assert found is None or violations(problem, found) == ()
    assert found is not None or n > 4


def test_a_few_things_do_not_huddle():
    """Sixteen boxes take all four quarters of the table."""
    result = solve(loose(16, 1), 0)
    assert isinstance(result, Solved)
    quarters = {(at.x_m > 0, at.y_m > 0) for at in result.placements.values()}
    assert len(quarters) == 4


def test_ranges_are_kept_and_relations_are_left_to_others():
    problem = loose(4, 2)
    things = tuple(replace(t, domain=replace(t.domain, x_m=(0.1, 0.5), y_m=(-0.3, 0.3))) for t in problem.things)
    names = [thing.name for thing in things]
    found = spread_grid(model_of(replace(problem, things=things)), names, {}, 0)
    assert found is not None
    assert all(0.1 <= at.x_m <= 0.5 and -0.3 <= at.y_m <= 0.3 for at in found.values())
    related = replace(problem, relations=(SceneRelation("before", ("box0", "box1")),))
    assert spread_grid(model_of(related), names, {}, 0) is None
    assert spread_grid(model_of(loose(60, 0)), [f"box{i}" for i in range(60)], {}, 0) is None
