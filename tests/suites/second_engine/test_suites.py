"""Suites of acceptance end alike in MuJoCo, for what holds and for what must be lost; a disagreement is named."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from assetkit.acceptance.suites.common import CommonSuite
from assetkit.acceptance.suites.manipulated import ManipulatedSuite
from assetkit.acceptance.suites.suite import NOMINAL, Conditions
from assetkit.affordances.grasps import propose_grasps
from schemas.acceptance import Check
from sim.bullet.simulator import BulletSimulator
from sim.grasp_trial import Phase
from sim.port import DropSettings, Simulator, world_for
from tests.assetkit.acceptance.suites.subjects import subject
from tests.assetkit.affordances.test_grasps import THINGS
from tests.suites.second_engine.mujoco_simulator import MujocoSimulator
from tests.suites.second_engine.suites import Comparison, compare, likely_cause

MUJOCO = cast(Simulator, MujocoSimulator())  # Of the protocol it has what these suites need.


@pytest.mark.long
@pytest.mark.parametrize("name", ["box", "can", "ball"])
def test_what_a_gripper_handles_in_one_engine_it_handles_in_the_other(name: str) -> None:
    comparisons = list(compare(subject(THINGS[name], "manipulated")))
    assert [c.suite for c in comparisons] == ["common", "manipulated"]
    assert all(c.first.passes and c.second.passes for c in comparisons)
    assert all(c.disagreements() == [] for c in comparisons)


def test_what_slips_in_one_engine_slips_in_the_other() -> None:
    slick = subject(THINGS["box"], "manipulated", grasps=propose_grasps(THINGS["box"], ()).grasps[:1])
    slick = slick.under(Conditions(friction=-0.6))
    with BulletSimulator() as bullet:
        runs = [ManipulatedSuite().run(slick, simulator, NOMINAL) for simulator in (bullet, MUJOCO)]
    assert [[f.code for f in run.findings] for run in runs] == [["asset/handling-lost"]] * 2
    assert all(f"'{Phase.LIFT}'" in run.findings[0].headline for run in runs)


def test_a_drop_falls_as_far_as_gravity_takes_it() -> None:
    X_WA = np.eye(4)
    X_WA[2, 3] = 1.0
    result = MUJOCO.drop(THINGS["box"], X_WA, DropSettings(0.3, world_for(0.13)))
    assert result.positions_m[-1, 2] == pytest.approx(1.0 - 0.5 * 9.81 * result.times_s[-1] ** 2, abs=0.01)
    assert result.linear_mps[-1, 2] == pytest.approx(-9.81 * result.times_s[-1], rel=0.01)


def test_the_slope_is_as_steep_in_both() -> None:
    def slid(simulator: Simulator) -> float:
        checks = CommonSuite().run(subject(THINGS["box"]), simulator, NOMINAL).checks
        return next(check.value for check in checks if check.name == "slope_moved")

    with BulletSimulator() as bullet:
        assert slid(MUJOCO) == pytest.approx(slid(bullet), rel=0.1)


def test_a_disagreement_has_both_figures_and_a_cause() -> None:
    near = [Check(name="slip", value=v, bound=0.01, unit="m", passed=v <= 0.01) for v in (0.0095, 0.0105)]
    far = [replace_value(near[0], 0.001), replace_value(near[1], 0.03)]
    assert likely_cause(*near).startswith("a matter of degree")
    assert "soft constraint" in likely_cause(*far)
    with BulletSimulator() as bullet:
        run = ManipulatedSuite().run(subject(THINGS["box"], "manipulated"), bullet, NOMINAL)
    worse = replace(run, checks=tuple(replace_value(c, 1.0) if c.name == "slip" else c for c in run.checks))
    comparison = Comparison("thing", "manipulated", run, worse)
    assert not comparison.agree
    assert [line.split(":")[0] for line in comparison.disagreements()] == ["slip"]


def replace_value(check: Check, value: float) -> Check:
    return check.model_copy(update={"value": value, "passed": value <= check.bound})
