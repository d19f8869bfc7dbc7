"""The suite of supports: a table passes; slanted, slippery and top-heavy ones fail, each by its code."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import NOMINAL, Conditions, SuiteRun
from assetkit.acceptance.suites.support import SupportSuite
from geom.pose import pose, rotation_about
from schemas.anchors import AnchorPolygon, Ring, SupportSurface
from schemas.physics import CollisionShape, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.loading import LoadOutcome, LoadTask
from tests.assetkit.acceptance.suites.crates import top
from tests.assetkit.acceptance.suites.subjects import subject
from tests.support.sample_bodies import boxes

SUITE = SupportSuite()
TOP_M, EDGE = 0.42, 0.5


def table(foot_m: float) -> RigidBody:
    """A top of 0.5 m on a column."""
    return boxes([((foot_m, foot_m, 0.4), (0.0, 0.0, 0.2)), ((EDGE, EDGE, 0.02), (0.0, 0.0, 0.41))])


def run(body: RigidBody, *surfaces: SupportSurface, conditions: Conditions = NOMINAL) -> SuiteRun:
    with BulletSimulator() as simulator:
        return SUITE.run(subject(body, "support", anchors=surfaces), simulator, conditions)


def codes(ended: SuiteRun) -> list[str]:
    return [finding.code for finding in ended.findings]


def value(ended: SuiteRun, name: str) -> float:
    return next(check.value for check in ended.checks if check.name == f"surface_0_{name}")


class Answer(FakeSimulator):
    """Loads as given; the tasks are kept."""

    def __init__(self, turn_rad: float = 0.0, shift_m: float = 0.0, lean_rad: float = 0.0) -> None:
        self.turn_rad, self.shift, self.lean_rad = turn_rad, np.array([shift_m, 0.0, 0.0]), lean_rad
        self.tasks = list[LoadTask]()

    def load(self, body: RigidBody, task: LoadTask) -> LoadOutcome:
        self.tasks.append(task)
        start = np.array([probe.shape.X_AS for probe in task.probes])
        turn = pose(rotation_about(np.array([1.0, 0.0, 0.0]), self.turn_rad))
        lean = pose(rotation_about(np.array([1.0, 0.0, 0.0]), self.lean_rad))
        end = start @ lean
        end[-1, :3, 3] += self.shift
        X_WA = np.stack([task.X_WA, turn @ task.X_WA])
        return LoadOutcome(np.array([0.0, 1.0]), X_WA, np.stack([start, turn @ end]))


@pytest.mark.parametrize("rate_hz", [120.0, 240.0, 480.0])
def test_a_table_on_a_wide_foot_carries_stacks_and_its_own_mass(rate_hz: float) -> None:
    ended = run(table(0.4), top(EDGE, TOP_M), conditions=Conditions(step_s=1.0 / rate_hz))
    assert codes(ended) == []
    assert ended.passes
    assert value(ended, "edge_load_limit") == POLICY.load_most


def test_the_load_limit_at_the_edge_is_that_of_the_lever() -> None:
    """The worst places are at the middle of a side: the lever of the load is as long there as at a corner."""
    foot_m = 0.2
    ended = run(table(foot_m), top(EDGE, TOP_M))
    box = POLICY.stack_edge * math.sqrt(EDGE**2 + EDGE**2 + TOP_M**2)
    out = 0.5 * EDGE - math.sqrt(0.5) * box - 0.5 * foot_m
    assert value(ended, "edge_load_limit") == pytest.approx(0.5 * foot_m / out, rel=0.05)
    assert value(ended, "middle_load_limit") == POLICY.load_most
    assert ended.passes


def test_a_table_on_a_thin_foot_tips_under_a_small_load_at_the_edge() -> None:
    ended = run(table(0.03), top(EDGE, TOP_M))
    assert "asset/support-tips" in codes(ended)
    assert value(ended, "edge_load_limit") < POLICY.load_edge


def test_a_mass_centre_beside_the_middle_tips_it_there() -> None:
    body = table(0.1)
    off = replace(body, mass=replace(body.mass, centre_of_mass_m=np.array([0.045, 0.0, 0.3])))
    far = top(0.1, TOP_M).model_copy(update={"position_m": (0.15, 0.0, TOP_M)})
    ended = run(off, far)
    assert "asset/support-tips" in codes(ended)
    assert value(ended, "middle_load_limit") < POLICY.load_middle


def test_boxes_slide_off_a_surface_that_slants_in_its_colliders() -> None:
    foot = CollisionShape("box", (0.4, 0.4, 0.3), pose(None, (0.0, 0.0, 0.15)))
    turned = rotation_about(np.array([0.0, 1.0, 0.0]), math.radians(35.0))
    slanted = CollisionShape("box", (0.4, 0.4, 0.02), pose(turned, (0.0, 0.0, 0.45)))
    body = replace(table(0.4), shapes=(foot, slanted))
    assert "asset/support-stack" in codes(run(body, top(0.2, 0.46)))


def test_boxes_fall_through_a_surface_that_is_not_there() -> None:
    foot = CollisionShape("box", (0.4, 0.4, 0.3), pose(None, (0.0, 0.0, 0.15)))
    assert "asset/support-stack" in codes(run(replace(table(0.4), shapes=(foot,)), top(EDGE, TOP_M)))


def test_a_promise_without_a_surface_is_not_kept() -> None:
    assert codes(SUITE.run(subject(table(0.4), "support"), FakeSimulator(), NOMINAL)) == ["asset/support-no-surface"]


@pytest.mark.parametrize(
    ("answer", "code"),
    [
        (Answer(), None),
        (Answer(turn_rad=math.radians(6.0)), "asset/support-tips"),
        (Answer(shift_m=0.02), "asset/support-stack"),
        (Answer(lean_rad=math.radians(6.0)), "asset/support-stack"),
    ],
)
def test_each_figure_beyond_its_bound_is_a_finding(answer: Answer, code: str | None) -> None:
    ended = SUITE.run(subject(table(0.2), "support", anchors=(top(EDGE, TOP_M),)), answer, NOMINAL)
    assert codes(ended) == ([] if code is None else [code])
    assert ended.passes == (code is None)


def test_stacks_and_loads_weigh_and_stand_where_they_should() -> None:
    body, answer = table(0.2), Answer()
    SUITE.run(subject(body, "support", anchors=(top(EDGE, TOP_M),)), answer, Conditions(step_s=1.0 / 480.0))
    stacks, middle, edge = answer.tasks
    assert {task.step_s for task in answer.tasks} == {1.0 / 480.0}
    assert len(stacks.probes) == 2 * POLICY.stack
    assert sum(probe.mass_kg for probe in stacks.probes[3:]) == pytest.approx(POLICY.load_edge * body.mass.mass_kg)
    assert np.diff([probe.shape.X_AS[2, 3] for probe in stacks.probes[:3]]).min() > stacks.probes[0].shape.size_m[2]
    assert middle.probes[0].mass_kg == pytest.approx(POLICY.load_sure * POLICY.load_most * body.mass.mass_kg)
    assert np.hypot(*middle.probes[0].shape.X_AS[:2, 3]) < 0.01
    assert np.abs(edge.probes[0].shape.X_AS[:2, 3]).max() > 0.2


def test_of_all_places_near_the_edge_the_worst_one_counts() -> None:
    """The top is twice as long as it is wide: the limit is that of its ends."""
    wide = boxes([((0.2, 0.2, 0.4), (0.0, 0.0, 0.2)), ((0.8, 0.4, 0.02), (0.0, 0.0, 0.41))])
    ring = ((-0.4, -0.2), (0.4, -0.2), (0.4, 0.2), (-0.4, 0.2))
    ended = SUITE.run(subject(wide, "support", anchors=(_outlined(ring),)), Answer(), NOMINAL)
    box = POLICY.stack_edge * math.sqrt(0.8**2 + 0.4**2 + TOP_M**2)
    assert value(ended, "edge_load_limit") == pytest.approx(0.1 / (0.3 - math.sqrt(0.5) * box), rel=0.05)


def test_a_small_surface_gets_one_stack() -> None:
    answer = Answer()
    ended = SUITE.run(subject(table(0.2), "support", anchors=(top(0.05, TOP_M),)), answer, NOMINAL)
    assert len(answer.tasks[0].probes) == POLICY.stack
    assert value(ended, "middle_stack_moved") == 0.0


def _outlined(ring: Ring) -> SupportSurface:
    return top(EDGE, TOP_M).model_copy(update={"polygon": AnchorPolygon(outline_m=ring)})


def test_a_box_fits_under_what_is_above_a_surface() -> None:
    answer = Answer()
    low = top(EDGE, 0.1).model_copy(update={"clearance_m": 0.03})
    SUITE.run(subject(table(0.2), "support", anchors=(low,)), answer, NOMINAL)
    highest = max(p.shape.X_AS[2, 3] + 0.5 * p.shape.size_m[2] for p in answer.tasks[0].probes)
    assert highest <= 0.13 + 1e-9
