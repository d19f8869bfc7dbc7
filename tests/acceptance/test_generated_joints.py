"""A released drawer is pushed where its record says that a hand takes hold, and carries a cube that lies in it.

The package is made by `mana assets generate`: contacts, insides and colliders are those that the pipeline found.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from assetkit.acceptance.joints.checks import JudgedJoint
from assetkit.acceptance.joints.judge_joints import judge_joints
from assetkit.acceptance.joints.tasks import joint_tasks, link_points
from schemas.anchors import Anchor
from schemas.articulation import JointContact
from schemas.asset import AssetRecord
from sim.bullet.simulator import BulletSimulator
from sim.joint_exercise import Articulation
from sim.port import Simulator
from usdio.reread.body import RereadPackage, reread_package

pytestmark = pytest.mark.long  # 12 s to make the package
JOINT = "drawer_1"


@pytest.fixture(scope="module")
def bullet() -> Iterator[Simulator]:
    with BulletSimulator() as simulator:
        yield simulator


@dataclass(frozen=True)
class ReleasedDrawers:
    """A package, what is read back from it, and what its record says of its joints."""

    main_file: Path
    content: RereadPackage
    contacts: Mapping[str, JointContact]
    anchors: Sequence[Anchor]

    @property
    def articulation(self) -> Articulation:
        assert self.content.mechanism is not None
        return Articulation(self.content.mechanism, self.content.links, self.content.filtered_pairs)

    def judge(
        self, simulator: Simulator, contacts: Mapping[str, JointContact], anchors: Sequence[Anchor]
    ) -> JudgedJoint:
        return judge_joints(
            self.main_file,
            self.content,
            simulator,
            declared=self.articulation.mechanism,
            contacts=contacts,
            anchors=anchors,
        )


@pytest.fixture(scope="module")
def drawers(tmp_path_factory: pytest.TempPathFactory) -> ReleasedDrawers:
    out = tmp_path_factory.mktemp("library")
    command = [sys.executable, "-m", "cli.main", "assets", "generate", "drawer_unit", "--set", "levels=1"]
    subprocess.run([*command, "--jobs", "1", "--json", "--out", str(out)], check=True, capture_output=True, timeout=300)
    record = AssetRecord.model_validate_json((out / "drawer_unit" / "record.json").read_bytes())
    main_file = out / "drawer_unit" / "usd" / "drawer_unit.usda"
    contacts = {use.joint: use.contact.value for use in record.joint_uses if use.contact is not None}
    return ReleasedDrawers(main_file, reread_package(main_file), contacts, [each.value for each in record.anchors])


def test_the_hand_takes_the_handle_and_the_probe_lies_in_the_drawer(drawers: ReleasedDrawers) -> None:
    (task,) = joint_tasks(drawers.articulation, drawers.contacts, drawers.anchors)
    assert drawers.contacts[JOINT].kind == "handle"
    assert task.contact == pytest.approx(drawers.contacts[JOINT].position_m)
    foremost = {link: link_points(drawers.articulation, link)[:, 0].max() for link in ("body", JOINT)}
    assert foremost["body"] < task.contact[0] < foremost[JOINT] + 1e-3  # in front of the case
    assert task.probe is not None
    low, high = (f(link_points(drawers.articulation, JOINT), axis=0) for f in (np.min, np.max))
    middle, half = task.probe.X_AS[:3, 3], 0.5 * task.probe.size_m[0]
    assert half > 0.005
    assert np.all(low < middle - half)
    assert np.all(middle + half < high)


def test_pushed_there_the_drawer_opens_and_carries_the_probe(drawers: ReleasedDrawers, bullet: Simulator) -> None:
    judged = drawers.judge(bullet, drawers.contacts, drawers.anchors)
    assert judged.diagnostics == ()
    checks = {check.name: check for check in judged.checks}
    names = ("push_reaches_upper", "push_reaches_lower", "probe_lags", "contact_to_collider")
    assert all(checks[f"joint.{JOINT}.{name}"].passed for name in names)
    (joint,) = drawers.articulation.mechanism.joints
    assert joint.limits is not None
    lag_m = checks[f"joint.{JOINT}.probe_lags"].value
    assert isinstance(lag_m, float)
    assert lag_m < 0.05 * (joint.limits[1] - joint.limits[0])


def test_a_place_in_the_air_is_none_to_push_at(drawers: ReleasedDrawers, bullet: Simulator) -> None:
    x, y, z = drawers.contacts[JOINT].position_m
    astray = {JOINT: drawers.contacts[JOINT].model_copy(update={"position_m": (x + 0.1, y, z)})}
    assert [d.code for d in drawers.judge(bullet, astray, drawers.anchors).diagnostics] == [
        "asset/joint-contact-astray"
    ]


def test_a_cube_that_does_not_lie_in_the_drawer_stays_behind(drawers: ReleasedDrawers, bullet: Simulator) -> None:
    """The inside is said to be on top of the case, whose lid does not move."""
    top_m = float(link_points(drawers.articulation, "body")[:, 2].max())
    raised = [
        anchor.model_copy(update={"position_m": (*anchor.position_m[:2], top_m)}) if anchor.link == JOINT else anchor
        for anchor in drawers.anchors
    ]
    assert [d.code for d in drawers.judge(bullet, drawers.contacts, raised).diagnostics] == ["asset/joint-probe-lost"]
