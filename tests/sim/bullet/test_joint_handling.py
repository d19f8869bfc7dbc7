"""The gripper at a joint in PyBullet: forces are those that the joint resists with, at every size."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geom.pose import pose
from sim.bullet.joint_handling import handle_joint
from sim.fake import FakeSimulator
from sim.joint_exercise import Articulation
from sim.joint_handling import HandlingTask
from tests.support.mechanism.drawn_cabinet import DrawnCabinet
from usdio.reread.body import reread_package
from usdio.write.package import write_package

# Pads above and below the handle of the drawer, the hand before it.
X_AG = pose(np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), (0.192, 0.0, 0.09))
TASK = HandlingTask("slide", 0.0, 0.2, X_AG, 0.03, True, True, force_n=70.0, hand_n=140.0, friction=0.6)


@pytest.fixture(scope="module")
def cabinet(tmp_path_factory: pytest.TempPathFactory) -> Articulation:
    return articulation(DrawnCabinet(), tmp_path_factory.mktemp("package"))


def articulation(drawn: DrawnCabinet, folder: Path) -> Articulation:
    content = drawn.content()
    read = reread_package(write_package(content, folder / content.asset_id))
    assert read.mechanism is not None
    return Articulation(read.mechanism, read.links, read.filtered_pairs)


def with_slide(cabinet: Articulation, **changes: float) -> Articulation:
    joints = tuple(replace(j, **changes) if j.name == "slide" else j for j in cabinet.mechanism.joints)
    return replace(cabinet, mechanism=replace(cabinet.mechanism, joints=joints))


@pytest.mark.parametrize("friction_n", [10.0, 40.0])
def test_the_hand_needs_what_the_joint_resists_with(friction_n: float, cabinet: Articulation) -> None:
    free = handle_joint(with_slide(cabinet, friction=0.0, damping=0.0), TASK)
    held = handle_joint(with_slide(cabinet, friction=friction_n, damping=0.0), TASK)
    assert held.reached == pytest.approx(0.2, abs=0.002)
    assert held.force_n - free.force_n == pytest.approx(friction_n, abs=4.0)


def test_a_spring_is_felt_in_full_by_the_hand(cabinet: Articulation) -> None:
    """Over a short way the hand is slow, and the spring nearly alone."""
    sprung = handle_joint(with_slide(cabinet, damping=0.0, stiffness=1500.0), replace(TASK, end=0.02))
    assert sprung.force_n == pytest.approx(1500.0 * 0.02, abs=4.0)


def test_damping_is_felt_by_the_speed_of_the_hand(cabinet: Articulation) -> None:
    joint = next(j for j in cabinet.mechanism.joints if j.name == "slide")
    fastest_mps = 1.5 * 0.2 / TASK.move_s(joint)
    free = handle_joint(with_slide(cabinet, damping=0.0), TASK)
    damped = handle_joint(with_slide(cabinet, damping=100.0), TASK)
    assert damped.force_n - free.force_n == pytest.approx(100.0 * fastest_mps, abs=6.0)


def test_a_model_of_a_large_object_gives_true_forces_and_ways(tmp_path: Path) -> None:
    """On a wall of 9 m the cabinet is simulated at half its size: ways and forces stay those of the true one."""
    wall = DrawnCabinet().with_box("cabinet", "wall", ((-0.25, -4.5, 0.0), (-0.21, 4.5, 3.0)))
    large = articulation(wall, tmp_path)
    held = handle_joint(with_slide(large, friction=40.0, damping=0.0, stiffness=50.0), TASK)
    assert held.reached == pytest.approx(0.2, abs=0.003)
    assert held.back == pytest.approx(0.0, abs=0.003)
    assert held.force_n == pytest.approx(40.0 + 50.0 * 0.2, abs=9.0)


def test_pads_slip_where_friction_does_not_carry(cabinet: Articulation) -> None:
    """Both pads carry 2 x 0.6 x 10 N at most."""
    weak = replace(TASK, force_n=10.0)
    assert handle_joint(with_slide(cabinet, friction=8.0, damping=0.0), weak).reached > 0.19
    assert handle_joint(with_slide(cabinet, friction=20.0, damping=0.0), weak).reached < 0.02


def test_equal_trials_end_equal(cabinet: Articulation) -> None:
    assert handle_joint(cabinet, TASK) == handle_joint(cabinet, TASK)


def test_the_fake_moves_a_joint_as_far_as_it_goes(cabinet: Articulation) -> None:
    outcome = FakeSimulator().handle_joint(cabinet, replace(TASK, end=0.5))
    assert (outcome.began, outcome.reached, outcome.back) == pytest.approx((0.0, 0.3, 0.0))
