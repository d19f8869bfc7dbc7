"""The suite of every object: what stands passes; what clings to a slope or falls now and then does not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from assetkit.acceptance.suites.common import CommonSuite
from assetkit.acceptance.suites.suite import NOMINAL, SuiteRun
from geom.pose import pose
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.port import DropResult, DropSettings
from tests.assetkit.acceptance.suites.subjects import subject
from tests.assetkit.affordances.test_grasps import THINGS, body_of, box

SUITE = CommonSuite()


class Drops(BulletSimulator):
    """The engine's drops, changed after the fact."""

    def __init__(self, change: Callable[[DropResult, DropSettings, FloatArray], DropResult]) -> None:
        super().__init__()
        self.change = change

    def drop(self, body: RigidBody, X_WA: FloatArray, settings: DropSettings) -> DropResult:
        return self.change(super().drop(body, X_WA, settings), settings, X_WA)


def run(body: RigidBody, simulator: BulletSimulator) -> SuiteRun:
    with simulator:
        return SUITE.run(subject(body), simulator, NOMINAL)


def codes(result: SuiteRun) -> list[str]:
    return [finding.code for finding in result.findings]


def is_sloped(settings: DropSettings) -> bool:
    return settings.world.gravity_mps2[0] != 0.0


@pytest.mark.parametrize("name", THINGS)
@pytest.mark.parametrize("friction", [0.05, 1.2])
def test_whatever_its_friction_a_thing_slides_down_and_settles_alike(name: str, friction: float) -> None:
    body = THINGS[name]
    contact = body.contact.model_copy(update={"dynamic_friction": friction, "static_friction": friction})
    assert codes(run(replace(body, contact=contact), BulletSimulator())) == []


def test_what_stays_on_the_slope_is_found() -> None:
    def stuck(result: DropResult, settings: DropSettings, X_WA: FloatArray) -> DropResult:
        return replace(result, positions_m=0.0 * result.positions_m) if is_sloped(settings) else result

    assert codes(run(THINGS["box"], Drops(stuck))) == ["asset/slope-astray"]


def test_what_jumps_off_the_slope_is_found() -> None:
    def jumping(result: DropResult, settings: DropSettings, X_WA: FloatArray) -> DropResult:
        late = np.linspace(0.0, 0.5, len(result.heights_m))
        return replace(result, heights_m=result.heights_m + late) if is_sloped(settings) else result

    assert codes(run(THINGS["box"], Drops(jumping))) == ["asset/slope-astray"]


def test_what_stands_on_a_foot_too_narrow_for_a_slight_lean_does_not_settle_alike() -> None:
    foot = CollisionShape("cylinder", (0.005, 0.01), pose(None, (0.0, 0.0, 0.005)))
    top_heavy = body_of(foot, box(0.05, 0.05, 0.4, (0.0, 0.0, 0.21)), centre_m=(0.0, 0.0, 0.39))
    result = run(top_heavy, BulletSimulator())
    assert codes(result) == ["asset/settling-unrepeatable"]
    assert "lean" in result.findings[0].headline


def test_what_ends_elsewhere_at_another_step_is_found() -> None:
    def off(result: DropResult, settings: DropSettings, X_WA: FloatArray) -> DropResult:
        if settings.world.timestep_s != 1.0 / 480.0:
            return result
        moved = np.linspace(0.0, 0.1, len(result.positions_m))[:, None]
        return replace(result, positions_m=result.positions_m + moved)

    result = run(THINGS["box"], Drops(off))
    assert codes(result) == ["asset/settling-unrepeatable"]
    assert "480 steps" in result.findings[0].headline


def test_what_balances_on_a_point_has_no_pose_to_repeat() -> None:
    checks = [check.name for check in run(THINGS["ball"], BulletSimulator()).checks]
    assert "seed_1_tilt" not in checks
    assert "slope_moved" in checks
