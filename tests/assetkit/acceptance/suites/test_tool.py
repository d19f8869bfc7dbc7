"""The suite of tools: a hammer is swung at its handle; one that slips, turns or cannot be held fails by its code."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import NOMINAL, Conditions, Subject, SuiteRun
from assetkit.acceptance.suites.tool import ToolSuite, tool_grasps, use_motion
from assetkit.affordances.grasps import propose_grasps
from geom.pose import apply, pose_from_quat
from schemas.affordances import Grasp, Region
from schemas.physics import CollisionShape, MassProperties, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.grasp_trial import LIFT_M, GraspOutcome, Phase
from tests.assetkit.acceptance.suites.subjects import subject
from tests.assetkit.acceptance.suites.test_manipulated import Outcome
from tests.assetkit.affordances.test_grasps import CONTACT, box

SUITE = ToolSuite()
USED = GraspOutcome(None, 0.0, released=True)
HALF_M = 0.1  # length of the handle, either way
HAMMER = RigidBody(
    "hammer",
    (box(2 * HALF_M, 0.025, 0.025, (0.0, 0.0, 0.03)), box(0.03, 0.06, 0.06, (HALF_M, 0.0, 0.03))),
    MassProperties(0.3, np.array([0.03, 0.0, 0.03]), np.diag([2e-4, 1.5e-3, 1.5e-3])),
    CONTACT,
)
RIM = ((0.05, 0.0, 0.04), (0.0, 0.05, 0.04))


def handle(*held_by: str, middle: float = -0.05, thick_m: float = 0.025) -> Region:
    line = tuple((x, 0.0, 0.03) for x in np.linspace(middle - 0.05, middle + 0.05, 11).tolist())
    return Region(
        kind="handle", affordance_id="handle_0", task="carry", interaction="wrap", position_m=(middle, 0.0, 0.03),
        direction=(0.0, 0.0, 1.0), outline_m=line, size_m=thick_m, held_by=held_by,
    )  # fmt: skip


def region(kind: str) -> Region:
    return Region.model_validate(
        {**handle().model_dump(), "kind": kind, "affordance_id": f"{kind}_0", "task": "pour", "interaction": "tilt"}
    )


def hammer(*regions: Region, grasps: tuple[Grasp, ...] = (), body: RigidBody = HAMMER) -> Subject:
    return subject(body, "tool", grasps=grasps, regions=regions)


def run(here: Subject, conditions: Conditions = NOMINAL) -> SuiteRun:
    with BulletSimulator() as simulator:
        return SUITE.run(here, simulator, conditions)


def codes(ended: SuiteRun) -> list[str]:
    return [finding.code for finding in ended.findings]


@pytest.mark.parametrize("rate_hz", [240.0, 480.0])
def test_a_hammer_is_swung_at_its_handle_and_keeps_its_place(rate_hz: float) -> None:
    ended = run(hammer(handle()), Conditions(step_s=1.0 / rate_hz))
    assert codes(ended) == []
    assert ended.trace is not None
    heads = ended.trace.X_WA[:, :3, 0]  # along the handle, in the world
    assert np.abs(heads[:, 2]).max() > math.sin(math.radians(75.0))  # It pointed up or down on the way,
    assert abs(heads[-1, 2]) < 0.1  # and is level again.


def test_a_slippery_hammer_is_lost() -> None:
    grasps, _ = tool_grasps(hammer(handle()))
    ended = run(hammer(handle(), grasps=tuple(grasps)), Conditions(friction=-0.6))
    assert codes(ended) == ["asset/tool-lost"]
    assert "'lift'" in ended.findings[0].headline


def test_a_heavy_head_turns_between_pads_that_press_with_the_force_of_the_record() -> None:
    """The record was made for a head a tenth as heavy."""
    body = replace(HAMMER, mass=replace(HAMMER.mass, centre_of_mass_m=np.array([0.09, 0.0, 0.03]), mass_kg=1.0))
    (grasp, *_), _ = tool_grasps(hammer(handle(middle=-0.08)))
    ended = run(hammer(handle(middle=-0.08), grasps=(grasp,), body=body))
    assert codes(ended) in (["asset/tool-slip"], ["asset/tool-lost"])


def test_a_handle_that_no_gripper_takes_fails_with_the_reason() -> None:
    thick = RigidBody("club", (box(0.2, 0.2, 0.2),), MassProperties(0.3, np.array([0, 0, 0.1]), np.eye(3)), CONTACT)
    ended = SUITE.run(hammer(handle(thick_m=0.2), body=thick), FakeSimulator(), NOMINAL)
    assert codes(ended) == ["asset/tool-no-grasp"]
    assert "136 mm" in ended.findings[0].headline


def test_a_hammer_is_not_held_by_its_head_where_it_has_a_handle() -> None:
    all_grasps = propose_grasps(HAMMER, ()).grasps
    chosen, _ = tool_grasps(hammer(handle(), grasps=all_grasps))
    assert chosen
    assert max(grasp.position_m[0] for grasp in chosen) < 0.03
    assert any(grasp.position_m[0] > 0.08 for grasp in all_grasps)  # Others would take the head.


def test_grasps_that_are_on_record_for_the_handle_come_first_and_refuted_ones_not_at_all() -> None:
    a, b, c = propose_grasps(HAMMER, ()).grasps[:3]
    recorded = (a, b.model_copy(update={"trial": "held"}), c.model_copy(update={"trial": "not_held"}))
    names = [grasp.affordance_id for grasp in recorded]
    chosen, _ = tool_grasps(hammer(handle(*names), grasps=recorded))
    assert [grasp.affordance_id for grasp in chosen] == [b.affordance_id, a.affordance_id]


def test_without_a_handle_it_is_held_far_from_the_mass_centre() -> None:
    chosen, _ = tool_grasps(hammer())
    levers = [math.dist(grasp.position_m, HAMMER.mass.centre_of_mass_m) for grasp in chosen]
    every = [math.dist(g.position_m, HAMMER.mass.centre_of_mass_m) for g in propose_grasps(HAMMER, ()).grasps]
    assert min(levers) >= POLICY.far_share * max(every)
    assert len(chosen) < len(every)


@pytest.mark.parametrize(
    ("outcome", "code"),
    [
        (USED, None),
        (GraspOutcome(Phase.SWING, math.inf, released=False), "asset/tool-lost"),
        (replace(USED, slip_m=0.03), "asset/tool-slip"),
        (replace(USED, slip_m=math.nan), "asset/tool-slip"),
    ],
)
def test_each_figure_beyond_its_bound_is_a_finding(outcome: GraspOutcome, code: str | None) -> None:
    ended = SUITE.run(hammer(handle()), Outcome(outcome), NOMINAL)
    assert codes(ended) == ([] if code is None else [code])
    assert ended.passes == (code is None)


def test_a_use_that_is_lost_at_the_beginning_keeps_fewer_phases_than_one_at_the_end() -> None:
    lost = [GraspOutcome(phase, math.inf, released=False) for phase in (Phase.LIFT, Phase.STIR)]
    early, late = (SUITE.run(hammer(handle()), Outcome(outcome), NOMINAL).checks[0].value for outcome in lost)
    assert early < late


@pytest.mark.parametrize(
    ("kinds", "phases"), [((), {Phase.SWING, Phase.STIR}), (("rim",), {Phase.TILT}), (("spout",), {Phase.TILT})]
)
def test_regions_decide_what_is_done_with_it(kinds: tuple[str, ...], phases: set[Phase]) -> None:
    here = hammer(handle(), *(region(kind) for kind in kinds))
    (grasp, *_), _ = tool_grasps(here)
    done = {phase for phase, _ in use_motion(here, grasp).phases}
    assert done & {Phase.SWING, Phase.STIR, Phase.TILT} == phases


def test_it_is_lifted_until_it_can_turn_above_the_ground() -> None:
    long = replace(HAMMER, shapes=(*HAMMER.shapes, CollisionShape("box", (0.7, 0.02, 0.02), np.eye(4))))
    here = hammer(handle())
    (grasp, *_), _ = tool_grasps(here)
    assert use_motion(here, grasp).lift_m == LIFT_M
    motion = use_motion(hammer(handle(), body=long), grasp)
    X_AG = pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m)
    tip = apply(X_AG, np.zeros((1, 3)))[0] - np.array([0.35, 0.0, 0.0])
    assert motion.lift_m > math.hypot(0.35, tip[2]) - 0.05
    assert motion.lift_m > LIFT_M
