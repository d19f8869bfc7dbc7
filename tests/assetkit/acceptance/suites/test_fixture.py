"""The gripper opens a drawn cabinet by its handles, turns and presses what is drawn, and each way to break it is found.

Which code answers which defect is the assertion; a suite that lets one through fails here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from assetkit.acceptance.suites.fixture import FixtureSuite
from assetkit.acceptance.suites.suite import NOMINAL, Subject, SuiteRun
from schemas.articulation import JointContact, JointTask, JointUse
from schemas.evidence import inferred
from schemas.mechanism import MechanismJoint
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.joint_exercise import Articulation
from sim.joint_handling import HandlingOutcome, HandlingTask
from sim.port import Simulator
from tests.support.mechanism.drawn_cabinet import HANDLE, DrawnCabinet
from usdio.reread.body import reread_package
from usdio.write.package import write_package

GRIP_BAR = ((0.221, 0.15, 0.18), (0.25, 0.165, 0.27))
DOOR_HANDLE = JointContact(
    kind="handle",
    link="door",
    position_m=(0.25, 0.157, 0.225),
    normal=(1.0, 0.0, 0.0),
    low_m=GRIP_BAR[0],
    high_m=GRIP_BAR[1],
    pull=(1.0, 0.0, 0.0),
)
GOOD = DrawnCabinet().with_box("door", "handle", GRIP_BAR)
SUITE = FixtureSuite()


@pytest.fixture(scope="module")
def bullet() -> Iterator[Simulator]:
    with BulletSimulator() as simulator:
        yield simulator


def use(joint: str, contact: JointContact, end: float, task: JointTask = "open", group: str = "drawer") -> JointUse:
    return JointUse(
        joint=joint,
        group=inferred(group, "drawn", 0.9),
        task=task,
        closed=inferred(0.0, "drawn", 0.9),
        open=inferred(end, "drawn", 0.9),
        contact=inferred(contact, "drawn", 0.9),
    )


SLIDE_USE = use("slide", HANDLE, 0.3)
HINGE_USE = use("hinge", DOOR_HANDLE, 1.8, group="hinged_door")


def subject(cabinet: DrawnCabinet, folder: Path, *uses: JointUse) -> Subject:
    content = cabinet.content()
    main_file = write_package(content, folder / content.asset_id)
    return Subject(main_file, reread_package(main_file), ("fixture",), joint_uses=uses)


def run(cabinet: DrawnCabinet, folder: Path, simulator: Simulator, *uses: JointUse) -> SuiteRun:
    written = subject(cabinet, folder, *uses)
    assert SUITE.obstacle(written) == ""
    return SUITE.run(written, simulator, NOMINAL)


def codes(result: SuiteRun) -> set[str]:
    return {finding.code for finding in result.findings}


def figure(result: SuiteRun, name: str) -> float:
    return next(check.value for check in result.checks if check.name == name)


def test_the_gripper_opens_a_good_cabinet_by_its_handles_and_shuts_it(bullet: Simulator, tmp_path: Path) -> None:
    result = run(GOOD, tmp_path, bullet, SLIDE_USE, HINGE_USE)
    assert result.passes, result.findings
    for joint in ("slide", "hinge"):
        assert figure(result, f"joint.{joint}.by_pads") == 1.0
        assert figure(result, f"joint.{joint}.opened") >= 0.95
        assert figure(result, f"joint.{joint}.kept") >= 0.95
        assert figure(result, f"joint.{joint}.back") <= 0.02
    drawer, door = result.handled
    assert drawer.positions.max() == pytest.approx(0.3, abs=0.01)
    assert door.positions.max() == pytest.approx(1.8, abs=0.05)
    # The fingers went along: those of the door were turned by its angle.
    turned = door.X_AB[:, 0, :3, :3] @ door.X_AB[0, 0, :3, :3].T
    assert np.degrees(np.arccos((np.trace(turned, axis1=1, axis2=2).min() - 1.0) / 2.0)) == pytest.approx(
        103.0, abs=4.0
    )


def test_equal_runs_end_equal(bullet: Simulator, tmp_path: Path) -> None:
    made = subject(GOOD, tmp_path, SLIDE_USE)
    assert SUITE.run(made, bullet, NOMINAL).checks == SUITE.run(made, bullet, NOMINAL).checks


def test_a_handle_behind_the_body_is_not_taken(bullet: Simulator, tmp_path: Path) -> None:
    """A cover before the drawer: the handle is there, and nobody gets at it."""
    covered = GOOD.with_box("cabinet", "cover", ((0.21, -0.2, 0.0), (0.23, 0.2, 0.15)))
    assert codes(run(covered, tmp_path, bullet, SLIDE_USE)) == {"asset/handle-not-taken"}


def test_a_handle_that_an_arm_cannot_reach_is_not_taken(bullet: Simulator, tmp_path: Path) -> None:
    """A hood on the drawer with room for a hand around the handle, but not for the arm behind it."""
    hood = GOOD
    for name, box in {
        "front": ((0.37, -0.3, 0.0), (0.38, 0.3, 0.31)),
        "left": ((0.23, -0.3, 0.0), (0.37, -0.29, 0.31)),
        "right": ((0.23, 0.29, 0.0), (0.37, 0.3, 0.31)),
        "lid": ((0.23, -0.3, 0.3), (0.38, 0.3, 0.31)),
    }.items():
        hood = hood.with_box("drawer", name, box)
    assert codes(run(hood, tmp_path, bullet, SLIDE_USE)) == {"asset/handle-not-taken"}


def test_a_handle_without_collider_is_not_taken(bullet: Simulator, tmp_path: Path) -> None:
    missing = replace(GOOD, without_collider=frozenset({"handle"}))
    bare = HANDLE.model_copy(update={"low_m": (0.18, -0.05, 0.08)})
    assert codes(run(missing, tmp_path, bullet, use("slide", bare, 0.3))) == {"asset/handle-not-taken"}


@pytest.mark.parametrize(("joint", "use_of_it"), [("slide", SLIDE_USE), ("hinge", HINGE_USE)])
def test_an_axis_of_the_wrong_sign_is_astray(
    joint: str, use_of_it: JointUse, bullet: Simulator, tmp_path: Path
) -> None:
    axis = next(j.axis for j in GOOD.joints if j.name == joint)
    turned = GOOD.with_joint(joint, axis=-axis)
    assert codes(run(turned, tmp_path, bullet, use_of_it)) == {"asset/handle-astray"}


def test_an_axis_of_the_wrong_sign_is_not_taken_where_the_record_has_the_same_sign(
    bullet: Simulator, tmp_path: Path
) -> None:
    """A door that opens into a block: the hand would have to go through it."""
    solid = GOOD.with_box("cabinet", "block", ((-0.18, -0.18, 0.15), (0.19, 0.18, 0.28)))
    inward = DOOR_HANDLE.model_copy(update={"pull": (-1.0, 0.0, 0.0)})
    turned = solid.with_joint("hinge", axis=np.array([0.0, 0.0, 1.0]))
    assert codes(run(turned, tmp_path, bullet, use("hinge", inward, 1.8))) == {"asset/handle-not-taken"}


@pytest.mark.parametrize(
    "stuck",
    [
        {"friction": 400.0},
        {"limits": (0.0, 0.02)},
    ],
)
def test_a_stuck_joint_is_not_opened(stuck: dict[str, object], bullet: Simulator, tmp_path: Path) -> None:
    found = codes(run(GOOD.with_joint("slide", **stuck), tmp_path, bullet, SLIDE_USE))
    assert found == {"asset/handle-not-opened"}


def test_a_joint_that_takes_more_than_a_gripper_has_is_forced(bullet: Simulator, tmp_path: Path) -> None:
    """Fingers hooked behind a bar bring 75 N, which is more than the 70 N of the gripper; a smooth handle slips off."""
    hook = GOOD.with_box("drawer", "bar", ((0.2, -0.05, 0.02), (0.21, 0.05, 0.16)))
    heavy = {"friction": 75.0}
    assert codes(run(hook.with_joint("slide", **heavy), tmp_path / "hook", bullet, SLIDE_USE)) == {
        "asset/handle-forced"
    }
    slips = run(GOOD.with_joint("slide", **heavy), tmp_path / "smooth", bullet, SLIDE_USE)
    assert codes(slips) == {"asset/handle-not-opened"}


PRESSED = MechanismJoint(
    "press",
    "prismatic",
    "cabinet",
    "button",
    np.array([0.0, 0.0, 0.32]),
    np.array([0.0, 0.0, -1.0]),
    limits=(0.0, 0.006),
    damping=0.5,
    stiffness=400.0,
    source_name="press",
)
BUTTON_BOX = ((-0.015, -0.015, 0.31), (0.015, 0.015, 0.325))
BUTTON = JointContact(
    kind="button",
    link="button",
    position_m=(0.0, 0.0, 0.325),
    normal=(0.0, 0.0, 1.0),
    low_m=BUTTON_BOX[0],
    high_m=BUTTON_BOX[1],
    pull=(0.0, 0.0, -1.0),
)
PRESS_USE = use("press", BUTTON, 0.006, "press", "button")


def with_button(joint: MechanismJoint = PRESSED) -> DrawnCabinet:
    boxes = {**GOOD.boxes, "button": {"cap": BUTTON_BOX}}
    return replace(GOOD, boxes=boxes, joints=(*GOOD.joints, joint))


def test_closed_fingers_press_a_button_and_its_spring_brings_it_back(bullet: Simulator, tmp_path: Path) -> None:
    result = run(with_button(), tmp_path, bullet, PRESS_USE)
    assert result.passes, result.findings
    assert figure(result, "joint.press.by_pads") == 0.0
    assert figure(result, "joint.press.opened") >= 0.95


def test_a_button_too_stiff_for_a_finger_is_not_pressed(bullet: Simulator, tmp_path: Path) -> None:
    stiff = replace(PRESSED, stiffness=2e5)
    assert "asset/handle-not-opened" in codes(run(with_button(stiff), tmp_path, bullet, PRESS_USE))


def test_a_button_that_sticks_is_not_returned(bullet: Simulator, tmp_path: Path) -> None:
    """Friction that its spring cannot overcome."""
    sticks = replace(PRESSED, friction=4.0)
    assert codes(run(with_button(sticks), tmp_path, bullet, PRESS_USE)) == {"asset/handle-not-returned"}


TURNED = MechanismJoint(
    "turn",
    "revolute",
    "cabinet",
    "knob",
    np.array([0.22, 0.0, 0.35]),
    np.array([1.0, 0.0, 0.0]),
    limits=(0.0, 4.0),
    friction=0.02,
    source_name="turn",
)
KNOB_BOX = ((0.21, -0.02, 0.33), (0.24, 0.02, 0.37))


def test_a_knob_is_turned_as_far_as_a_wrist_turns(bullet: Simulator, tmp_path: Path) -> None:
    knob = JointContact(
        kind="knob",
        link="knob",
        position_m=(0.24, 0.0, 0.37),
        normal=(0.0, 0.0, 1.0),
        low_m=KNOB_BOX[0],
        high_m=KNOB_BOX[1],
        pull=(0.0, -1.0, 0.0),
    )
    cabinet = replace(
        DrawnCabinet(),
        boxes={**DrawnCabinet().boxes, "knob": {"cap": KNOB_BOX}},
        joints=(*DrawnCabinet().joints, TURNED),
    )
    result = run(cabinet, tmp_path, bullet, use("turn", knob, 4.0, "turn", "knob"))
    assert result.passes, result.findings
    assert result.handled[0].positions.max() == pytest.approx(2.9, abs=0.1)


class Altered:
    """The simulator with what it says of a trial changed."""

    def __init__(self, simulator: Simulator, **changes: object) -> None:
        self._simulator, self._changes = simulator, changes

    def handle_joint(self, articulation: Articulation, task: HandlingTask) -> HandlingOutcome:
        return replace(self._simulator.handle_joint(articulation, task), **self._changes)

    def __getattr__(self, name: str) -> object:
        return getattr(self._simulator, name)


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"kept": 0.3}, "asset/handle-lost"),
        ({"force_n": 1000.0}, "asset/handle-forced"),
        ({"reached": 0.1}, "asset/handle-not-opened"),
        ({"back": 0.2}, "asset/handle-not-returned"),
        ({"fastest": 30.0}, "asset/handle-unstable"),
        ({"finite": False}, "asset/handle-unstable"),
    ],
)
def test_each_figure_out_of_bounds_is_named(changes: dict[str, object], code: str, tmp_path: Path) -> None:
    altered = cast(Simulator, Altered(FakeSimulator(), **changes))
    assert codes(run(GOOD, tmp_path / "good", FakeSimulator(), SLIDE_USE)) == set()
    assert codes(run(GOOD, tmp_path, altered, SLIDE_USE)) == {code}


def test_without_a_known_use_on_record_it_is_not_run(tmp_path: Path) -> None:
    unknown = SLIDE_USE.model_copy(update={"group": inferred("unknown", "drawn", 0.0)})
    assert "no joint" in SUITE.obstacle(subject(GOOD, tmp_path / "a", unknown))
    assert "no joint" in SUITE.obstacle(subject(GOOD, tmp_path / "b"))
