"""Laws of the arguments: a problem seen in a mirror, turned by a right angle, or listed in another order has the same
answer; what is dropped from a problem that has a scene leaves one that is not refuted."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.affinity import affine_transform

from scenec.check.judge_scene import violations, world_poses
from scenec.ir.problem import Placement, Problem, Thing
from scenec.ir.relaxed import relaxed, rules
from scenec.proofs import prove, prove_cheaply
from tests.support.scene.proof_problems import box_body, problem, table, thing
from tests.support.scene.random_problems import random_problem

MIRROR = np.array([[-1.0, 0.0], [0.0, 1.0]])
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])


def seen(case: Problem, M: np.ndarray) -> Problem:
    """The problem with the whole table mapped by an axis-swapping or mirroring matrix (boxes are symmetric)."""

    def moved(polygon):
        return affine_transform(polygon, [*M.ravel(), 0.0, 0.0])

    def changed(item: Thing) -> Thing:
        assert not item.place.is_volume
        axes = [item.domain.x_m, item.domain.y_m]
        order = [int(np.argmax(abs(row))) for row in M]
        ranges = [tuple(sorted(float(M[k, order[k]]) * np.array(axes[order[k]]))) for k in range(2)]
        low, high = item.domain.yaw_rad
        yaw = (-high, -low) if np.linalg.det(M) < 0 else (low + np.pi / 2, high + np.pi / 2)
        domain = replace(item.domain, x_m=ranges[0], y_m=ranges[1], yaw_rad=yaw)
        return replace(item, place=replace(item.place, polygon=moved(item.place.polygon)), domain=domain)

    def directed(relation):
        return replace(relation, direction=tuple(float(v) for v in M @ np.array(relation.direction)))

    reach = case.reach
    return replace(
        case,
        things=tuple(changed(item) for item in case.things),
        relations=tuple(directed(r) for r in case.relations if r.kind != "facing"),
        keep_outs=tuple(replace(rule, polygon=moved(rule.polygon)) for rule in case.keep_outs),
        reach=None if reach is None else replace(reach, base_m=np.array([*(M @ reach.base_m[:2]), 0.0])),
    )


def without_facing(case: Problem) -> Problem:
    # The front of a box seen in a mirror points elsewhere than its mapped +x; all else maps exactly.
    return replace(case, relations=tuple(r for r in case.relations if r.kind != "facing"))


@pytest.mark.parametrize("M", [MIRROR, QUARTER], ids=["mirror", "quarter turn"])
@settings(max_examples=30, deadline=None)
@given(st.integers(0, 5000))
def test_seen_from_elsewhere_the_answer_is_the_same(M, seed):
    case = without_facing(random_problem(seed))
    assert (prove_cheaply(case) is None) == (prove_cheaply(seen(case, M)) is None)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 5000), st.randoms(use_true_random=False))
def test_listed_in_another_order_the_answer_is_the_same(seed, dice: random.Random):
    case = random_problem(seed)
    things, relations = list(case.things), list(case.relations)
    dice.shuffle(things)
    dice.shuffle(relations)
    other = replace(case, things=tuple(things), relations=tuple(relations))
    assert (prove_cheaply(case) is None) == (prove_cheaply(other) is None)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 5000))
def test_the_same_problem_has_the_same_proof_to_the_letter(seed):
    case = random_problem(seed)
    assert prove(case, most_programs=20) == prove(replace(case), most_programs=20)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 5000), st.integers(0, 2**16))
def test_dropping_rules_never_makes_a_proof(seed, chosen):
    case = random_problem(seed)
    dropped = [path for k, path in enumerate(rules(case)) if chosen >> k & 1]
    if prove_cheaply(relaxed(case, dropped)) is not None:
        assert prove(case) is not None


def test_what_stands_on_a_turned_tray_is_judged_in_the_world():
    tray = box_body("tray", 0.3, 0.2, 0.02, holds=True)
    case = problem(
        [
            thing("tray", tray, table(1.0, 1.0), yaw=(-np.pi, np.pi)),
            thing("cup", (0.1, 0.1), tray.surfaces[0], parent="tray"),
            thing("jug", (0.1, 0.1), table(1.0, 1.0)),
        ]
    )
    at = {
        name: Placement(*pose, 0)
        for name, pose in {"tray": (0.1, 0.0, np.pi / 2), "cup": (0.1, 0.05, 0.0), "jug": (0.3, 0.0, 0.0)}.items()
    }
    origin, yaw = world_poses(case, at)["cup"]
    assert origin == pytest.approx([0.1 - 0.05, 0.1, 0.02])
    assert yaw == pytest.approx(np.pi / 2)
    assert violations(case, at) == ()
    off = at | {"cup": Placement(0.11, 0.05, 0.0, 0)}
    assert [(v.kind, v.names) for v in violations(case, off)] == [("off_support", ("cup", "tray"))]
    near = at | {"jug": Placement(0.255, 0.0, 0.0, 0)}
    assert [(v.kind, v.names) for v in violations(case, near)] == [("clearance", ("tray", "jug"))]
