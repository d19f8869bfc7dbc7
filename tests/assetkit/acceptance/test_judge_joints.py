"""Sabotage: a drawn cabinet passes the exercise of its joints, and every way to break it is found, by name.

Each defect is put into the package before it is written, or into a file of the written package; what is judged is read
back from disk. Which check or code answers which defect is the assertion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.acceptance.joints.checks import JudgedJoint
from assetkit.acceptance.joints.judge_joints import joints_in_loops, judge_joints
from assetkit.acceptance.joints.policy import POLICY
from assetkit.acceptance.joints.tasks import farthest_point, joint_tasks
from assetkit.package.write_twins import write_twins
from schemas.diagnostics import Severity
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismLink
from sim.bullet.simulator import BulletSimulator
from sim.fake import FakeSimulator
from sim.joint_exercise import ALL_RUNS, Articulation
from sim.port import Simulator
from tests.support.mechanism.drawn_cabinet import HANDLE, HINGE, INSIDE, SLIDE, DrawnCabinet
from usdio.reread.body import RereadPackage, reread_package
from usdio.write.package import write_package


@pytest.fixture(scope="module")
def bullet() -> Iterator[Simulator]:
    with BulletSimulator() as simulator:
        yield simulator


@dataclass(frozen=True)
class Written:
    """A written package and what is read back from it."""

    main_file: Path
    content: RereadPackage

    def judge(self, simulator: Simulator, declared: Mechanism) -> JudgedJoint:
        return judge_joints(
            self.main_file,
            self.content,
            simulator,
            declared=declared,
            contacts={"slide": HANDLE},
            anchors=[INSIDE],
        )


def written(cabinet: DrawnCabinet, folder: Path) -> Written:
    content = cabinet.content()
    main_file = write_package(content, folder / content.asset_id)
    read_back = reread_package(main_file)
    write_twins(read_back, content, main_file.parents[1])
    return Written(main_file, read_back)


def codes(judged: JudgedJoint) -> list[str]:
    return [d.code for d in judged.diagnostics]


def failed(judged: JudgedJoint) -> set[str]:
    return {check.name for check in judged.checks if not check.passed}


GOOD = DrawnCabinet()
LONG_HANDLE = GOOD.with_box("drawer", "handle", ((0.17, -0.05, 0.08), (0.26, 0.05, 0.1)))


def test_a_good_cabinet_passes_and_its_figures_are_in_the_checks(bullet: Simulator, tmp_path: Path) -> None:
    judged = written(GOOD, tmp_path).judge(bullet, GOOD.mechanism)
    assert codes(judged) == []
    assert failed(judged) == set()
    assert not judged.review
    names = {check.name for check in judged.checks}
    for joint in ("slide", "hinge"):
        ends = {f"{a}_reaches_{e}" for a in ("drive", "push") for e in ("lower", "upper")}
        for figure in ends | {"overrun", "axis", "returns", "speed", "penetration"}:
            assert f"joint.{joint}.{figure}" in names
    assert {
        "joint.slide.probe_lags",
        "joint.slide.contact_to_collider",
        "urdf_twin_angle",
        "mjcf_twin_position",
    } <= names
    assert {"links_overlap_colliding", "links_overlap_filtered"} <= names


def test_the_exercise_is_the_same_on_every_run(bullet: Simulator, tmp_path: Path) -> None:
    package = written(GOOD, tmp_path)
    first, again = (package.judge(bullet, GOOD.mechanism) for _ in range(2))
    assert first == again


@dataclass(frozen=True)
class Sabotage:
    """A cabinet with a defect, and the code and check that must find it."""

    cabinet: DrawnCabinet
    code: str
    check: str
    severity: Severity = Severity.ERROR


POST = ((0.25, -0.02, 0.03), (0.27, 0.02, 0.12))  # in front of the drawer
SABOTAGES = {
    "a post of the cabinet stands in front of the drawer": Sabotage(
        GOOD.with_box("cabinet", "post", POST),
        "asset/joint-penetration",
        "joint.slide.penetration",
        Severity.WARNING,
    ),
    "the door reaches down in front of the drawer": Sabotage(
        GOOD.with_box("door", "panel", ((0.205, -0.2, 0.03), (0.221, 0.19, 0.29))),
        "asset/joint-blocked",
        "joint.slide.drive_reaches_upper",
        Severity.WARNING,
    ),
    "the drawer may go through the back": Sabotage(
        GOOD.with_joint("slide", limits=(-0.3, 0.3)),
        "asset/joint-penetration",
        "joint.slide.penetration",
        Severity.WARNING,
    ),
    "the door turns into the cabinet": Sabotage(
        GOOD.with_joint("hinge", limits=(-1.5, 0.0)),
        "asset/joint-penetration",
        "joint.hinge.penetration",
        Severity.WARNING,
    ),
    "the inertia of the door explodes": Sabotage(
        replace(GOOD, inertia_factor={"door": 1e5}), "asset/joint-stuck", "joint.hinge.drive_reaches_upper"
    ),
    "the handle has no collider": Sabotage(
        replace(
            GOOD.with_box("drawer", "handle", ((0.17, -0.05, 0.08), (0.26, 0.05, 0.1))),
            without_collider=frozenset({"handle"}),
        ),
        "asset/joint-contact-astray",
        "joint.slide.contact_to_collider",
        Severity.WARNING,
    ),
    "the drawer has no floor": Sabotage(
        replace(GOOD, without_collider=frozenset({"bottom"})),
        "asset/joint-probe-lost",
        "joint.slide.probe_lags",
        Severity.WARNING,
    ),
    "door and drawer overlap at rest": Sabotage(
        GOOD.with_box("door", "panel", ((0.195, -0.2, 0.09), (0.221, 0.19, 0.29))),
        "asset/links-interpenetrate",
        "links_overlap_colliding",
    ),
}


@pytest.mark.parametrize("name", SABOTAGES)
def test_every_sabotage_is_found(name: str, bullet: Simulator, tmp_path: Path) -> None:
    sabotage = SABOTAGES[name]
    judged = written(sabotage.cabinet, tmp_path).judge(bullet, sabotage.cabinet.mechanism)
    assert sabotage.check in failed(judged)
    found = next(d for d in judged.diagnostics if d.code == sabotage.code)
    assert found.severity is sabotage.severity
    assert None not in (found.value, found.bound)
    assert found.unit
    assert found.help
    assert judged.review or sabotage.severity is Severity.ERROR


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"axis": -SLIDE.axis}, "asset/joint-axis-astray"),
        ({"axis": np.array([np.cos(0.03), np.sin(0.03), 0.0])}, "asset/joint-axis-astray"),
        ({"limits": (0.0, 0.32)}, "asset/joint-overruns-limit"),
        ({"limits": None}, "asset/joint-overruns-limit"),
        ({"limits": (0.0, 0.28)}, "asset/joint-stuck"),
        ({"limits": (0.02, 0.3), "rest": 0.02}, "asset/joint-stuck"),
    ],
)
def test_a_package_that_differs_from_what_was_declared_is_found(
    changes: dict, code: str, bullet: Simulator, tmp_path: Path
) -> None:
    """1.7 degrees are too much, and so is a limit that was lost or moved by 2 cm of 30, either way."""
    judged = written(GOOD.with_joint("slide", **changes), tmp_path).judge(bullet, GOOD.mechanism)
    assert code in codes(judged)


@pytest.mark.parametrize(("newtons", "jams"), [(540.0, False), (600.0, True)])
@pytest.mark.parametrize("name", ["slide", "hinge"])
def test_damping_that_no_hand_overcomes_is_found(name: str, newtons: float, jams: bool, tmp_path: Path) -> None:
    """At the far end of the door, 0.39 m from its axis; the drive of the exercise is stronger than any hand."""
    low, high = (SLIDE if name == "slide" else HINGE).limits or (0.0, 0.0)
    arm = 1.0 if name == "slide" else float(np.hypot(0.39, 0.02))
    jammed = GOOD.with_joint(name, damping=newtons * arm * 10.0 / (high - low))
    judged = written(jammed, tmp_path).judge(FakeSimulator(), jammed.mechanism)
    assert ("asset/joint-stuck" in codes(judged)) == jams


@pytest.mark.parametrize(
    ("suffix", "edit"),
    [
        (".urdf", lambda text: text.replace('<axis xyz="1.0 0.0', '<axis xyz="-1.0 0.0')),
        (".urdf", lambda text: text.replace('<joint name="slide"', '<joint name="slid"')),
        (".xml", lambda text: text.replace('axis="1.0 0.0 0.0"', 'axis="0.0 1.0 0.0"')),
        (".xml", lambda text: text[: len(text) // 2]),
        (".urdf", lambda text: text.replace('upper="0.3', 'upper="0.2')),
        (".xml", lambda text: text.replace('range="0.0 0.3', 'range="0.0 0.2')),
    ],
)
def test_a_twin_that_moves_another_way_is_found(suffix: str, edit: Callable[[str], str], tmp_path: Path) -> None:
    package = written(GOOD, tmp_path)
    twin = package.main_file.parents[1] / "export" / f"{package.main_file.stem}{suffix}"
    text = twin.read_text()
    twin.write_text(edit(text))
    assert twin.read_text() != text
    judged = package.judge(FakeSimulator(), GOOD.mechanism)
    assert codes(judged) == ["asset/twin-disagrees"]


def test_ball_joints_and_loops_are_said_not_to_be_exercised_in_full(bullet: Simulator, tmp_path: Path) -> None:
    ball = GOOD.with_joint("hinge", kind="ball", limits=None)
    judged = written(ball, tmp_path / "a").judge(bullet, ball.mechanism)
    assert codes(judged) == ["asset/joint-not-exercised"]
    assert not any(check.name.startswith("joint.hinge") for check in judged.checks)
    closing = MechanismJoint("close", "revolute", "drawer", "door", np.zeros(3), HINGE.axis, closes_loop=True)
    loop = replace(GOOD, joints=(SLIDE, HINGE, closing))
    assert joints_in_loops(loop.mechanism) == {"slide", "hinge"}


def test_tasks_have_fewer_runs_for_many_joints_and_push_at_the_far_end(tmp_path: Path) -> None:
    package = written(GOOD, tmp_path).content
    assert package.mechanism is not None
    articulation = Articulation(package.mechanism, package.links)
    assert [task.runs for task in joint_tasks(articulation, {}, ())] == [ALL_RUNS] * 2
    hinge = next(j for j in package.mechanism.joints if j.name == "hinge")
    assert farthest_point(articulation, hinge)[1] == pytest.approx(0.19, abs=1e-6)
    joints = tuple(replace(HINGE, name=f"hinge_{k}", child=f"door_{k}") for k in range(POLICY.most_joints + 5))
    door = next(body for body in package.links if body.name == "door")
    many = Articulation(
        Mechanism((package.mechanism.root, *(MechanismLink(j.child, j.anchor) for j in joints)), joints),
        (package.links[0], *(replace(door, name=j.child) for j in joints)),
    )
    tasks = joint_tasks(many, {}, ())
    assert len(tasks) == POLICY.most_joints
    assert {task.runs for task in tasks} == {(("drive", "fast"),)}


def test_joints_that_follow_others_move_with_them(bullet: Simulator, tmp_path: Path) -> None:
    """The drawer comes out as the door opens, 0.3 m in 1.8 rad: no run of its own, nothing to complain of."""
    coupled = GOOD.with_joint("slide", coupling=JointCoupling("hinge", 0.3 / 1.8, 0.0))
    package = written(coupled, tmp_path)
    judged = judge_joints(package.main_file, package.content, bullet, declared=coupled.mechanism)
    assert codes(judged) == []
    assert not any(check.name.startswith("joint.slide") for check in judged.checks)
    assert any(check.name.startswith("joint.hinge") for check in judged.checks)
