"""Conflicts judged by the solver: the members contradict one another, and without any one of them there is a scene."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from shapely import box

from scenec.check.judge_scene import violations
from scenec.explain.minimal_conflict import minimal_conflict, quick_xplain
from scenec.explain.suggestions import _least_change, suggestions
from scenec.ir.problem import Problem, Result, Solved
from scenec.ir.relaxed import nodes, relaxed, rules
from scenec.proofs import prove
from scenec.solve import solve
from schemas.scene.geometry import KeepOutVolume
from tests.support.scene.proof_problems import box_body, left_of, problem, table, thing

TABLE = table(1.2, 0.8)
RANGE = "layout", "nodes", "a", "placement", "ranges"


def feasible(case: Problem) -> Result:
    result = solve(case, 0, 4000)
    assert not isinstance(result, Solved) or violations(case, result.placements) == ()
    return result


def conflict_of(case: Problem):
    conflict = minimal_conflict(case, feasible)
    assert conflict is not None
    if not any(path in nodes(case) for path in conflict.paths):
        alone = relaxed(case, set(rules(case)) - set(conflict.paths))
        assert prove(alone) is not None
        for path in conflict.paths:
            assert isinstance(feasible(relaxed(alone, {path})), Solved)
    return conflict


def circle(extra: int = 0) -> Problem:
    things = [thing(f"o{k}", (0.1, 0.06), TABLE, yaw=(-np.pi, np.pi)) for k in range(10)]
    harmless = [left_of(10 + k, f"o{3 + k}", f"o{4 + k}") for k in range(extra)]
    around = [left_of(k, f"o{k}", f"o{(k + 1) % 3}") for k in range(3)]
    return problem(things, [*harmless, *around])


def test_the_circle_of_three_is_named_exactly_in_a_tenth_of_a_second():
    case = circle(extra=5)
    conflict, spent = None, []
    for _ in range(4):
        start = time.process_time()
        conflict = minimal_conflict(case, feasible)
        spent.append(time.process_time() - start)
    assert min(spent) < 0.1
    assert conflict is not None
    assert set(conflict.paths) == {("relations", k) for k in range(3)}
    assert conflict.minimal


def test_one_of_two_conflicts_is_named_and_is_minimal_by_itself():
    case = circle()
    far = left_of(3, "o4", "o5", 1.5)
    conflict = conflict_of(replace(case, relations=(*case.relations, far)))
    assert set(conflict.paths) in ({("relations", k) for k in range(3)}, {("relations", 3)})
    assert conflict.minimal


def test_a_range_against_a_relation():
    case = problem(
        [thing("a", (0.1, 0.1), TABLE, x=(0.3, 0.4), y=(0.0, 0.0)), thing("b", (0.1, 0.1), TABLE, x=(-0.2, 0.2))],
        [left_of(0, "a", "b")],
    )
    conflict = conflict_of(case)
    assert set(conflict.paths) == {
        ("relations", 0),
        (*RANGE, "x"),
        ("layout", "nodes", "b", "placement", "ranges", "x"),
    }
    assert conflict.minimal


def test_a_keep_out_against_a_range():
    keep = KeepOutVolume("background", TABLE, box(0.2, -0.4, 0.6, 0.4), 0.1, ("keep_outs", 0))
    conflict = conflict_of(problem([thing("a", (0.1, 0.1), TABLE, x=(0.2, 0.3))], keep_outs=(keep,)))
    assert set(conflict.paths) == {("keep_outs", 0), (*RANGE, "x")}
    assert conflict.minimal


def test_clearance_when_things_fit_without_it():
    tiles = [thing(f"t{k}", (0.1, 0.1), table(0.305, 0.2)) for k in range(6)]
    conflict = conflict_of(problem(tiles, clearance=0.02))
    assert conflict.paths == (("clearance",),)


def test_things_that_have_no_room_at_all_are_the_conflict():
    case = problem([thing(name, (0.15, 0.15), table(0.2, 0.2)) for name in "abc"], [left_of(0, "a", "b")])
    conflict = conflict_of(case)
    assert set(conflict.paths) < {("layout", "nodes", name) for name in "abc"}
    assert len(conflict.paths) == 2
    assert conflict.minimal


def test_a_problem_with_a_scene_has_no_conflict():
    assert minimal_conflict(problem([thing("a", (0.1, 0.1), TABLE)]), feasible) is None


@pytest.mark.parametrize("guilty", [(0,), (3,), (0, 7), (2, 3, 4), tuple(range(8))])
def test_quick_xplain_finds_the_only_conflict(guilty):
    paths = tuple(("relations", k) for k in range(8))
    bad = {("relations", k) for k in guilty}
    assert set(quick_xplain(paths, lambda kept: bad <= set(kept))) == bad


def edits(case: Problem) -> tuple[str, ...]:
    suggested = suggestions(case, conflict_of(case), feasible)
    assert all(edit.verified for edit in suggested)
    return tuple(edit.edit for edit in suggested)


def test_a_gap_is_lowered_just_as_far_as_needed():
    place = table(0.3, 0.5)
    case = problem([thing(name, (0.1, 0.1), place) for name in "ab"], [left_of(0, "a", "b", 0.15)])
    assert "set gap of relations[0] to 0.1" in edits(case)


def test_a_range_is_widened_just_as_far_as_needed():
    case = problem(
        [thing("a", (0.1, 0.1), TABLE, x=(0.1, 0.2)), thing("b", (0.1, 0.1), TABLE, x=(-0.2, 0.1605))],
        [left_of(0, "a", "b")],
    )
    found = edits(case)
    assert "widen x of layout.nodes.a by 0.04 m downward" in found
    assert "widen x of layout.nodes.b by 0.04 m upward" in found
    assert "drop relations[0]" in found


def test_clearance_is_lowered_to_what_fits():
    tiles = [thing(f"t{k}", (0.1, 0.1), table(0.308, 0.204)) for k in range(6)]
    assert edits(problem(tiles, clearance=0.02)) == ("lower clearance to 0.004",)


def test_a_thing_is_moved_to_another_place_or_dropped():
    tray = box_body("tray", 0.3, 0.2, 0.02, holds=True)
    things = [thing("tray", tray, TABLE), *(thing(n, (0.12, 0.12), table(0.2, 0.2), parent="background") for n in "ab")]
    small = replace(table(0.2, 0.2), name="shelf")
    things = [things[0], *(replace(item, place=small) for item in things[1:])]
    found = edits(problem(things))
    assert "move a to tray" in found
    assert "drop layout.nodes.a" in found


def test_a_change_is_tried_to_its_very_end():
    assert _least_change(0.01, 0.0, 0.0001, lambda value: value <= 0.0) == 0.0
    assert _least_change(0.0, 1.28, 0.001, lambda value: value >= 1.28) == 1.28
    assert _least_change(0.0, 1.28, 0.001, lambda value: False) is None
