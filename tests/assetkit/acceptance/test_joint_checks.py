"""Checks of one joint on made-up exercises: which figure fails which bound, and which cause a finding names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assetkit.acceptance.joints.checks import JointSubject, JudgedJoint, judge_joint
from assetkit.acceptance.joints.policy import POLICY
from schemas.mechanism import MechanismJoint
from sim.joint_exercise import JointExercise, JointRun, LinkOverlap

HINGE = MechanismJoint(
    "hinge", "revolute", "case", "door", np.zeros(3), np.array([0.0, 0.0, 1.0]), limits=(0.0, 2.0), source_name="hinge"
)
RUN = JointRun("drive", "slow", 0.0, 2.0, 0.0, 0.5, 1.0, None, 0.0, True)
PUSH = replace(RUN, actuation="push", force_n=10.0)
GOOD = JointExercise("hinge", (0.0, 2.0), np.array([0.0, 0.0, 1.0]), (RUN, PUSH), ())
IN_THE_WAY = LinkOverlap("arm", "door", 0.01, collides=True, fixed=False, position=1.5)


def judged(
    exercise: JointExercise,
    *,
    joint: MechanismJoint = HINGE,
    at_rest: tuple[LinkOverlap, ...] = (),
    in_loop: bool = False,
) -> JudgedJoint:
    return judge_joint(JointSubject(joint, joint, exercise, at_rest, in_loop))


def with_run(**changes: object) -> JointExercise:
    return replace(GOOD, runs=(replace(RUN, **changes), PUSH))


def codes(result: JudgedJoint) -> list[str]:
    return [d.code for d in result.diagnostics]


def test_a_good_exercise_has_no_findings() -> None:
    result = judged(GOOD)
    assert all(check.passed for check in result.checks)
    assert codes(result) == []


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"finite": False}, "asset/joint-unstable"),
        ({"speed_mps": 1.01}, "asset/joint-unstable"),
        ({"speed_mps": np.inf}, "asset/joint-unstable"),
        ({"left_rest": 2.0 * POLICY.return_share + 1e-6}, "asset/joint-no-return"),
        ({"highest": 2.0 * (1.0 - POLICY.reach_share) - 1e-6}, "asset/joint-stuck"),
        ({"lowest": 2.0 * POLICY.reach_share + 1e-6}, "asset/joint-stuck"),
        ({"highest": 2.0 * (1.0 + POLICY.overrun_share) + 1e-6}, "asset/joint-overruns-limit"),
        ({"lowest": -2.0 * POLICY.overrun_share - 1e-6}, "asset/joint-overruns-limit"),
    ],
)
def test_each_figure_beyond_its_bound_is_one_finding_with_value_bound_and_unit(changes: dict, code: str) -> None:
    result = judged(with_run(**changes))
    assert codes(result) == [code]
    (finding,) = result.diagnostics
    assert isinstance(finding.value, float)
    assert isinstance(finding.bound, float)
    assert np.isfinite(finding.value)
    assert finding.value > finding.bound
    assert finding.unit
    assert "hinge" in finding.headline


@pytest.mark.parametrize(
    "changes",
    [
        {"left_rest": 2.0 * POLICY.return_share - 1e-6},
        {"highest": 2.0 * (1.0 - POLICY.reach_share) + 1e-6},
        {"highest": 2.0 * (1.0 + POLICY.overrun_share) - 1e-6},
        {"highest": 2.1, "step": 0.08},  # The engine notices a limit a step late.
    ],
)
def test_figures_within_their_bounds_pass(changes: dict) -> None:
    assert codes(judged(with_run(**changes))) == []


def test_a_link_that_others_move_away_blocks_and_one_that_they_do_not_is_a_stuck_joint() -> None:
    """Whether a person looks depends on the share that is left; the block must lie on the way that is missing."""
    stopped = with_run(highest=1.4)
    blocked = judged(replace(stopped, overlaps=(IN_THE_WAY,)))
    assert (codes(blocked), blocked.review) == (["asset/joint-blocked"], False)
    assert "arm" in blocked.diagnostics[0].headline
    early = judged(replace(with_run(highest=0.5), overlaps=(replace(IN_THE_WAY, position=0.6),)))
    assert (codes(early), early.review) == (["asset/joint-blocked"], True)
    for other in (
        replace(IN_THE_WAY, position=0.2),
        replace(IN_THE_WAY, fixed=True),
        replace(IN_THE_WAY, collides=False),
    ):
        assert codes(judged(replace(stopped, overlaps=(other,))))[0] == "asset/joint-stuck"
    assert codes(judged(stopped, in_loop=True)) == []


@pytest.mark.parametrize(("turned_deg", "expected"), [(0.9, []), (1.1, ["asset/joint-axis-astray"])])
def test_the_axis_may_be_off_by_one_degree(turned_deg: float, expected: list[str]) -> None:
    angle = np.radians(turned_deg)
    assert codes(judged(replace(GOOD, axis=np.array([np.sin(angle), 0.0, np.cos(angle)])))) == expected


def test_the_sign_of_the_axis_counts() -> None:
    (finding,) = judged(replace(GOOD, axis=np.array([0.0, 0.0, -1.0]))).diagnostics
    assert finding.value == pytest.approx(180.0)
    assert "other way round" in finding.headline


def test_penetration_counts_for_links_that_are_apart_at_rest_and_that_no_other_joint_parts() -> None:
    deep = LinkOverlap("case", "door", 0.002, collides=False, fixed=True, position=1.0)
    counted = judged(replace(GOOD, overlaps=(deep,)))
    assert (codes(counted), counted.review) == (["asset/joint-penetration"], True)
    shallow = replace(deep, depth_m=0.0009)
    assert codes(judged(replace(GOOD, overlaps=(shallow,)))) == []
    assert codes(judged(replace(GOOD, overlaps=(replace(deep, fixed=False),)))) == []
    rest = LinkOverlap("door", "case", 0.03, collides=False)
    assert codes(judged(replace(GOOD, overlaps=(deep,)), at_rest=(rest,))) == []
    endless = replace(HINGE, kind="continuous", limits=None)
    turning = judged(replace(GOOD, overlaps=(deep,)), joint=endless)
    assert (codes(turning), turning.review) == (["asset/joint-penetration"], False)
