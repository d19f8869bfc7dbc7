"""What is on record is tried again: what a sound object says of itself passes, each false statement has its finding."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from assetkit.acceptance.on_record import declared_on_record, judge_record
from assetkit.acceptance.stable_poses import find_stable_poses
from assetkit.acceptance.suites.suite import Subject, SuiteRun
from assetkit.physics.links import joint_evidence
from schemas.evidence import Evidence, declared
from schemas.physics import RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.port import Simulator
from tests.assetkit.acceptance.suites.crates import HEIGHT, LENGTH, crate, inside, top
from tests.assetkit.acceptance.suites.subjects import subject
from tests.support.mechanism.drawn_cabinet import HINGE, SLIDE, DrawnCabinet
from tests.support.sample_bodies import boxes

CRATE = crate()
MASS_KG = CRATE.mass.mass_kg
TALL = ((0.01, 0.06, 0.006), (0.0, 0.0, -0.003))  # a ridge below the floor
LID = ((LENGTH, LENGTH, 0.004), (0.0, 0.0, HEIGHT))


@pytest.fixture(scope="module")
def bullet() -> Iterator[Simulator]:
    with BulletSimulator() as simulator:
        yield simulator


@pytest.fixture(scope="module")
def recorded(bullet: Simulator) -> Subject:
    """The crate with its poses, its inside and bounds of its mass on record."""
    poses = find_stable_poses(CRATE, bullet).poses
    assert poses
    return replace(subject(CRATE, anchors=(inside(),)), poses=poses, mass_bounds_kg=(0.5 * MASS_KG, 2.0 * MASS_KG))


def with_body(recorded: Subject, body: RigidBody) -> Subject:
    return replace(recorded, content=replace(recorded.content, body=body))


def codes(run: SuiteRun) -> set[str]:
    return {finding.code for finding in run.findings}


def test_what_a_sound_object_says_of_itself_holds(recorded: Subject, bullet: Simulator) -> None:
    run = judge_record(recorded, bullet)
    assert run.findings == ()
    names = [check.name for check in run.checks]
    assert names[:2] == ["mass_above_least", "mass_below_most"]
    assert {"pose_1_height", "pose_1_holds", "anchors_holding"} <= set(names)


def test_where_nothing_is_on_record_nothing_is_tried(bullet: Simulator) -> None:
    assert judge_record(subject(CRATE), bullet).checks == ()


@pytest.mark.parametrize("factor", [0.4, 2.5])
def test_a_mass_beyond_its_bounds_is_found(factor: float, recorded: Subject, bullet: Simulator) -> None:
    body = replace(CRATE, mass=replace(CRATE.mass, mass_kg=factor * MASS_KG))
    assert codes(judge_record(with_body(recorded, body), bullet)) == {"asset/mass-beyond-bounds"}


def test_a_mass_centre_beyond_the_foot_loses_the_poses(recorded: Subject, bullet: Simulator) -> None:
    beyond = CRATE.mass.centre_of_mass_m + np.array([0.6 * LENGTH, 0.0, 0.0])
    body = replace(CRATE, mass=replace(CRATE.mass, centre_of_mass_m=beyond))
    run = judge_record(with_body(recorded, body), bullet)
    assert codes(run) == {"asset/stable-pose-lost"}
    assert all(check.passed for check in run.checks if check.name.endswith("_height"))


def test_a_ridge_under_the_foot_raises_the_object(recorded: Subject, bullet: Simulator) -> None:
    run = judge_record(with_body(recorded, replace(crate(TALL), mass=CRATE.mass)), bullet)
    assert "asset/stable-pose-lost" in codes(run)
    assert any(not check.passed and check.name.endswith("_height") for check in run.checks)


def test_a_lid_that_was_not_there_loses_the_volume(recorded: Subject, bullet: Simulator) -> None:
    run = judge_record(with_body(recorded, replace(crate(LID), mass=CRATE.mass)), bullet)
    assert codes(run) == {"asset/anchor-lost"}
    assert "volume_0" in run.findings[0].headline


@pytest.mark.parametrize(("tall", "found"), [(0.002, False), (0.01, True)])
def test_a_post_on_a_surface_loses_it_where_no_probe_lands(tall: float, found: bool, bullet: Simulator) -> None:
    """On a plate of 0.2 m; a bump that is lower than colliders may be off is none."""
    plate = ((0.2, 0.2, 0.02), (0.0, 0.0, 0.01))
    post = ((0.001, 0.001, tall), (0.03, 0.05, 0.02 + 0.5 * tall))
    run = judge_record(subject(boxes([plate, post]), anchors=(top(0.18, 0.02),)), bullet)
    assert codes(run) == ({"asset/anchor-lost"} if found else set())
    assert next(check for check in run.checks if check.name == "anchors_holding").passed


def stated_joints() -> tuple[Evidence[dict], ...]:
    return tuple(joint_evidence(joint) for joint in DrawnCabinet().joints)


def test_a_mechanism_is_as_declared_where_the_record_says_so() -> None:
    edited = DrawnCabinet().with_joint("slide", axis=-SLIDE.axis).with_joint("hinge", limits=(0.0, 3.0)).mechanism
    slide, hinge = declared_on_record(edited, stated_joints()).joints
    assert slide.axis == pytest.approx(SLIDE.axis)
    assert (slide.limits, hinge.limits) == (SLIDE.limits, HINGE.limits)


def test_joints_that_the_record_leaves_out_stay_as_they_are() -> None:
    mechanism = DrawnCabinet().mechanism
    other = declared({"name": "lid", "axis": (0.0, 1.0, 0.0)}, "joint of the source")
    assert declared_on_record(mechanism, (other,)).joints == mechanism.joints
