"""The suite of receptacles: a crate passes; one that is filled, open below, thin or tippy fails, each by its code."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.receptacle import ReceptacleSuite
from assetkit.acceptance.suites.suite import NOMINAL, Conditions, SuiteRun
from geom.pose import pose, rotation_about
from schemas.physics import MassProperties, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.loading import LoadOutcome, LoadTask
from tests.assetkit.acceptance.suites.crates import HEIGHT, LENGTH, WALL, Plate, crate, inside, top
from tests.assetkit.acceptance.suites.subjects import subject
from tests.support.sample_bodies import boxes

SUITE = ReceptacleSuite()
OUTER = LENGTH + 2.0 * WALL


def run(body: RigidBody, lift: float = 0.0, conditions: Conditions = NOMINAL) -> SuiteRun:
    with BulletSimulator() as simulator:
        return SUITE.run(subject(body, "receptacle", anchors=(inside(lift),)), simulator, conditions)


def codes(ended: SuiteRun) -> list[str]:
    return [finding.code for finding in ended.findings]


def value(ended: SuiteRun, name: str) -> float:
    return next(check.value for check in ended.checks if check.name == f"volume_0_{name}")


@pytest.mark.parametrize("rate_hz", [120.0, 240.0, 480.0])
def test_a_crate_holds_its_content_at_every_step_rate(rate_hz: float) -> None:
    ended = run(crate(), conditions=Conditions(step_s=1.0 / rate_hz))
    assert codes(ended) == []
    assert ended.passes
    body = crate()
    height = body.mass.centre_of_mass_m[2]
    assert value(ended, "tipping_empty") == pytest.approx(math.degrees(math.atan(0.5 * OUTER / height)), abs=0.5)


def test_a_promise_without_a_volume_is_not_kept() -> None:
    ended = SUITE.run(subject(crate(), "receptacle"), FakeSimulator(), NOMINAL)
    assert codes(ended) == ["asset/receptacle-no-volume"]
    assert not ended.passes


def test_a_flat_plate_holds_things_on_its_face_and_not_where_it_is_gone() -> None:
    flat = boxes([((0.2, 0.2, 0.01), (0.0, 0.0, 0.005))])
    plate = replace(subject(flat, "receptacle"), anchors=(top(0.18, 0.01),))
    with BulletSimulator() as simulator:
        assert SUITE.run(plate, simulator, NOMINAL).passes
        in_the_air = replace(plate, anchors=(top(0.18, 0.11),))
        assert codes(SUITE.run(in_the_air, simulator, NOMINAL)) == ["asset/receptacle-leaves"]


def test_things_do_not_stay_in_an_inside_that_colliders_fill() -> None:
    fill: Plate = ((LENGTH, LENGTH, HEIGHT), (0.0, 0.0, WALL + 0.5 * HEIGHT))
    assert "asset/receptacle-leaves" in codes(run(crate(fill)))


@pytest.mark.parametrize("gone", ["floor", "+x"])
def test_things_go_where_a_plate_is_missing(gone: str) -> None:
    ended = run(crate(without=gone))
    assert "asset/receptacle-tunnel" in codes(ended)
    assert value(ended, "tunnelling") >= 1


def test_things_fall_through_a_slit_in_the_floor() -> None:
    """A tenth of the floor is missing in its middle."""
    part = 0.45 * LENGTH
    halves: list[Plate] = [
        ((part, OUTER, WALL), (side * (0.5 * LENGTH - 0.5 * part), 0.0, 0.5 * WALL)) for side in (-1.0, 1.0)
    ]
    assert "asset/receptacle-tunnel" in codes(run(crate(*halves, without="floor")))


@pytest.mark.parametrize(("floor_m", "holds"), [(0.0002, False), (0.002, True)])
def test_a_floor_that_is_thinner_than_a_step_lets_fast_things_through(floor_m: float, holds: bool) -> None:
    ended = run(crate(floor=floor_m))
    assert ("asset/receptacle-tunnel" in codes(ended)) == (not holds)
    assert value(ended, "staying") == 1.0  # What falls slowly stays.


def test_a_crate_that_stands_at_its_rim_leans_when_it_is_full() -> None:
    """A heavy foot under one side carries the empty crate, but not content in the middle."""
    foot: Plate = ((0.04, OUTER, 0.03), (-0.5 * OUTER + 0.02, 0.0, 0.015))
    body = crate(foot, lift=0.03)
    low = MassProperties(0.2, np.array([-0.5 * OUTER + 0.02, 0.0, 0.02]), 2e-4 * np.eye(3))
    ended = run(replace(body, mass=low), lift=0.03)
    assert "asset/receptacle-spill" in codes(ended)
    assert value(ended, "content_tilt") > 5.0


def test_content_that_falls_out_below_is_spilt() -> None:
    lift = 0.1
    corners = [(x, y) for x in (-0.5 * OUTER, 0.5 * OUTER) for y in (-0.5 * OUTER, 0.5 * OUTER)]
    legs: list[Plate] = [((0.01, 0.01, lift + WALL), (x, y, 0.5 * (lift + WALL))) for x, y in corners]
    ended = run(crate(*legs, lift=lift, without="floor"), lift=lift)
    assert "asset/receptacle-spill" in codes(ended)
    assert value(ended, "content_kept") == 0.0
    assert value(ended, "content_tilt") < 5.0


@pytest.mark.parametrize(("foot_m", "tips"), [(0.03, True), (0.1, False)])
def test_a_crate_on_a_narrow_column_tips_on_a_slight_slope(foot_m: float, tips: bool) -> None:
    lift = 0.1
    column: Plate = ((foot_m, foot_m, lift), (0.0, 0.0, 0.5 * lift))
    ended = run(crate(column, lift=lift), lift=lift)
    assert ("asset/receptacle-tips" in codes(ended)) == tips
    assert (value(ended, "tipping_full") < math.degrees(POLICY.tip_rad)) == tips


def test_the_mass_of_conditions_decides_how_content_tips_it() -> None:
    """Content lies lower than the mass centre of the crate, and makes a light one steadier than a heavy one."""
    body = crate()
    heavy = run(body, conditions=Conditions(mass_kg=10.0 * body.mass.mass_kg))
    slight = run(body, conditions=Conditions(mass_kg=0.1 * body.mass.mass_kg))
    assert value(slight, "tipping_full") > value(heavy, "tipping_full") + 5.0
    assert value(heavy, "tipping_empty") == pytest.approx(value(slight, "tipping_empty"))


@pytest.mark.parametrize("conditions", [Conditions(mass_kg=1.0), Conditions(friction=0.2)])
def test_what_is_held_still_is_not_tried_again_at_other_masses_and_frictions(conditions: Conditions) -> None:
    simulator = FallsOnSlopes()
    SUITE.run(subject(crate(), "receptacle", anchors=(inside(),)), simulator, conditions)
    assert simulator.fixed == 0
    SUITE.run(subject(crate(), "receptacle", anchors=(inside(),)), simulator, Conditions(step_s=1.0 / 120.0))
    assert simulator.fixed == 2


class FallsOnSlopes(FakeSimulator):
    """Bodies turn by a radian when the ground is a slope; tasks on slopes are kept, those on fixed bodies counted."""

    def __init__(self) -> None:
        self.slopes, self.fixed = list[LoadTask](), 0

    def load(self, body: RigidBody, task: LoadTask) -> LoadOutcome:
        outcome = super().load(body, task)
        self.fixed += task.is_fixed
        if task.gravity_mps2[:2] == (0.0, 0.0):
            return outcome
        self.slopes.append(task)
        turned = pose(rotation_about(np.array([1.0, 0.0, 0.0]), 1.0)) @ task.X_WA
        return replace(outcome, X_WA=np.stack([task.X_WA, turned]))


def test_what_falls_over_on_a_slope_in_simulation_fails_whatever_geometry_gives() -> None:
    simulator = FallsOnSlopes()
    ended = SUITE.run(subject(crate(), "receptacle", anchors=(inside(),)), simulator, NOMINAL)
    assert "asset/receptacle-tips" in codes(ended)
    assert value(ended, "tipping_full") > math.degrees(POLICY.tip_rad)
    empty, full = simulator.slopes
    assert len(empty.probes) == 0 < len(full.probes)
    for task in simulator.slopes:
        pull = np.array(task.gravity_mps2)
        assert np.linalg.norm(pull) == pytest.approx(9.80665, rel=1e-3)
        assert math.acos(-pull[2] / np.linalg.norm(pull)) == pytest.approx(POLICY.tip_rad)


def test_the_slope_falls_to_the_weakest_side() -> None:
    body = crate()
    off = replace(body, mass=replace(body.mass, centre_of_mass_m=np.array([0.0, -0.03, 0.04])))
    simulator = FallsOnSlopes()
    SUITE.run(subject(off, "receptacle", anchors=(inside(),)), simulator, NOMINAL)
    pull = np.array(simulator.slopes[0].gravity_mps2)
    assert pull[1] < 0.0
    assert abs(pull[0]) < 0.1 * abs(pull[1])
