"""The suite of manipulated objects: what a gripper handles passes, and each way of failing has its code."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from assetkit.acceptance.suites.manipulated import ManipulatedSuite, grasps_to_try
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import NOMINAL, Conditions, SuiteRun
from assetkit.affordances.grasps import propose_grasps
from geom.grasp.gripper import GRIPPERS
from schemas.arrays import FloatArray
from schemas.physics import RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.grasp_trial import GraspOutcome, GraspTask, Landing, Phase
from tests.assetkit.acceptance.suites.subjects import subject
from tests.assetkit.affordances.test_grasps import THINGS, body_of, box

SUITE = ManipulatedSuite()
LIES = Landing(0.0, 0.0, 0.0, 0.0, is_supported=True)
GOOD = GraspOutcome(None, 0.0, released=True, landing=LIES)


class Outcome(FakeSimulator):
    """Every grasp ends as given; the tasks are kept."""

    def __init__(self, outcome: GraspOutcome) -> None:
        self.outcome, self.tasks = outcome, list[GraspTask]()

    def grasp(self, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
        self.tasks.append(task)
        return self.outcome


def codes(run: SuiteRun) -> list[str]:
    return [finding.code for finding in run.findings]


@pytest.mark.parametrize("name", ["box", "can", "ball"])
def test_a_thing_of_hand_size_is_taken_carried_and_set_down(name: str) -> None:
    with BulletSimulator() as simulator:
        run = SUITE.run(subject(THINGS[name], "manipulated"), simulator, NOMINAL)
    assert run.passes
    assert codes(run) == []
    assert run.trace is not None
    highest = run.trace.X_WA[:, 2, 3].max() - run.trace.X_WA[0, 2, 3]
    assert highest == pytest.approx(0.3, abs=0.03)  # It went up,
    assert run.trace.X_WA[-1, 2, 3] == pytest.approx(run.trace.X_WA[0, 2, 3], abs=0.005)  # down,
    # and to the end of the arc: 0.4 m times the chord of 60 degrees.
    assert math.dist(run.trace.X_WA[-1, :2, 3], run.trace.X_WA[0, :2, 3]) == pytest.approx(0.4, abs=0.03)


def test_too_little_friction_loses_it_while_it_is_lifted() -> None:
    with BulletSimulator() as simulator:
        grasps = propose_grasps(THINGS["box"], ()).grasps
        slippery = subject(THINGS["box"], "manipulated", grasps=grasps).under(Conditions(friction=-0.6))
        run = SUITE.run(slippery, simulator, NOMINAL)
    assert codes(run) == ["asset/handling-lost"]
    assert "'lift'" in run.findings[0].headline
    assert run.findings[0].value == list(Phase).index(Phase.LIFT)


def test_fingers_that_start_inside_push_it() -> None:
    body = THINGS["box"]
    grasp = propose_grasps(body, ()).grasps[0]
    narrow = grasp.model_copy(update={"opening_m": 0.6 * grasp.width_m})
    with BulletSimulator() as simulator:
        run = SUITE.run(subject(body, "manipulated", grasps=(narrow,)), simulator, NOMINAL)
    assert "asset/handling-pushed" in codes(run)


def test_what_is_too_wide_for_one_gripper_is_tried_with_a_larger_one() -> None:
    wide = body_of(box(0.11, 0.12, 0.1))
    grasps, reason = grasps_to_try(subject(wide, "manipulated"))
    assert reason == ""
    assert {grasp.gripper for grasp in grasps} == {"large"}
    assert all(grasp.width_m <= GRIPPERS["large"].widest_m() for grasp in grasps)
    with BulletSimulator() as simulator:
        assert SUITE.run(subject(wide, "manipulated"), simulator, NOMINAL).passes


def test_what_no_gripper_can_hold_fails_with_the_reason() -> None:
    too_wide = body_of(box(0.5, 0.5, 0.5), centre_m=(0.0, 0.0, 0.25))
    run = SUITE.run(subject(too_wide, "manipulated"), FakeSimulator(), NOMINAL)
    assert codes(run) == ["asset/handling-no-grasp"]
    assert "136 mm" in run.findings[0].headline


@pytest.mark.parametrize(
    ("outcome", "code"),
    [
        (GOOD, None),
        (replace(GOOD, moved_m=POLICY.moved_m + 1e-6), "asset/handling-pushed"),
        (replace(GOOD, moved_m=math.nan), "asset/handling-pushed"),
        (GraspOutcome(Phase.SHAKE, math.inf, released=False), "asset/handling-lost"),
        (replace(GOOD, slip_m=POLICY.slip_m + 1e-6), "asset/handling-slip"),
        (replace(GOOD, released=False), "asset/handling-not-released"),
        (replace(GOOD, landing=replace(LIES, is_supported=False)), "asset/handling-landing"),
        (replace(GOOD, landing=replace(LIES, penetration_m=0.02)), "asset/handling-landing"),
        (replace(GOOD, landing=replace(LIES, drift_m=0.03)), "asset/handling-landing"),
        (replace(GOOD, landing=replace(LIES, turn_rad=POLICY.landing_rad + 1e-6)), "asset/handling-landing"),
        (replace(GOOD, landing=replace(LIES, speed_mps=math.nan)), "asset/handling-landing"),
    ],
)
def test_each_figure_beyond_its_bound_is_a_finding(outcome: GraspOutcome, code: str | None) -> None:
    grasps = propose_grasps(THINGS["box"], ()).grasps[:1]
    run = SUITE.run(subject(THINGS["box"], "manipulated", grasps=grasps), Outcome(outcome), NOMINAL)
    assert codes(run) == ([] if code is None else [code])
    assert run.passes == (code is None)


def test_grasps_that_held_come_first_and_refuted_ones_not_at_all() -> None:
    a, b, c = propose_grasps(THINGS["box"], ()).grasps[:3]
    recorded = (a, b.model_copy(update={"trial": "held"}), c.model_copy(update={"trial": "not_held"}))
    tried, _ = grasps_to_try(subject(THINGS["box"], grasps=recorded))
    assert [grasp.affordance_id for grasp in tried] == [b.affordance_id, a.affordance_id]


def test_conditions_reach_the_engine_and_the_force_stays() -> None:
    grasps = propose_grasps(THINGS["box"], ()).grasps[:1]
    simulator = Outcome(GOOD)
    here = subject(THINGS["box"], "manipulated", grasps=grasps)
    SUITE.run(here, simulator, NOMINAL)
    SUITE.run(here, simulator, Conditions(friction=0.1, mass_kg=1.0, step_s=1.0 / 480.0))
    usual, other = simulator.tasks
    assert other.friction == pytest.approx(usual.friction - 0.5 * (0.4 - 0.1))
    assert other.force_n == usual.force_n
    assert other.step_s == 1.0 / 480.0


def test_what_has_joints_or_is_tiny_is_not_run() -> None:
    tiny = body_of(box(0.005, 0.005, 0.005), centre_m=(0.0, 0.0, 0.0025))
    assert "20 mm" in SUITE.obstacle(subject(tiny, "manipulated"))
    assert SUITE.obstacle(subject(THINGS["box"], "manipulated")) == ""
