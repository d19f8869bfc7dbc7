"""Written positions of joints become positions in metres and radians, or findings with both bounds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from scenec.bind.joint_states import JointState, joint_state
from schemas.diagnostics import Diagnostic
from schemas.mechanism import Mechanism
from tests.support.scene.articulated import articulated_library
from usdio.reread.body import reread_linkage


@pytest.fixture(scope="module")
def mechanisms(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Mechanism]:
    folder = articulated_library(tmp_path_factory.mktemp("library"))
    return {one.name: reread_linkage(one / "usd" / f"{one.name}.usda").mechanism for one in sorted(folder.iterdir())}


def finding_of(mechanism: Mechanism | None, **written: float) -> tuple[str, Diagnostic]:
    _, findings = joint_state("thing", mechanism, written)
    assert len(findings) == 1
    return findings[0]


def state_of(mechanism: Mechanism, **written: float) -> JointState:
    state, findings = joint_state("thing", mechanism, written)
    assert not findings
    return state


def test_degrees_and_radians_are_the_same_state(mechanisms: dict[str, Mechanism]):
    oven = mechanisms["microwave"]
    assert state_of(oven, door_deg=90.0) == state_of(oven, door=math.pi / 2) == (("door", math.pi / 2),)
    assert state_of(oven) == ()
    assert state_of(oven, turn=-40.0 * math.pi / 180, door=0.1) == (("door", 0.1), ("turn", -40.0 * math.pi / 180))


def test_a_joint_whose_name_ends_like_the_unit_is_meant_as_it_is(mechanisms: dict[str, Mechanism]):
    slides = mechanisms["drawer_unit"]
    first, second = slides.joints
    odd = replace(slides, joints=(replace(first, name="out_deg", source_name="out_deg"), second))
    assert state_of(odd, out_deg=0.1) == (("out_deg", 0.1),)


def test_names_of_the_source_are_known(mechanisms: dict[str, Mechanism]):
    slides = mechanisms["drawer_unit"]
    renamed = replace(slides, joints=tuple(replace(joint, source_name=f"{joint.name} (1)") for joint in slides.joints))
    state, findings = joint_state("thing", renamed, {"drawer_2 (1)": 0.1})
    assert (state, findings) == ((("drawer_2", 0.1),), ())


def test_a_name_of_its_own_comes_before_one_of_the_source(mechanisms: dict[str, Mechanism]):
    """`a.b` and `a_b` of a source become `a_b` and `a_b_1`; the first of them is what `a_b` means in a package."""
    slides = mechanisms["drawer_unit"]
    first, second = slides.joints
    both = (replace(first, name="a_b_1", source_name="a_b"), replace(second, name="a_b", source_name="a.b"))
    assert state_of(replace(slides, joints=both), a_b=0.1) == (("a_b", 0.1),)


def test_many_turns_in_single_precision_are_still_the_limit(mechanisms: dict[str, Mechanism]):
    """A valve of sixteen turns: 105 rad become 6016.056 degrees in float32, which are 3.6 urad less."""
    oven = mechanisms["microwave"]
    door, turn = oven.joints
    limit = math.radians(float(np.float32(math.degrees(105.0))))
    assert limit < 105.0 - 1e-6
    valve = replace(oven, joints=(door, replace(turn, kind="revolute", limits=(0.0, limit))))
    assert state_of(valve, turn=105.0) == (("turn", limit),)
    assert finding_of(valve, turn=-0.001)[1].code == "scene/joint-range"


@pytest.mark.parametrize("limit", [0.0, 0.25])
def test_a_limit_itself_can_be_written_and_is_not_passed_by_rounding(mechanisms: dict[str, Mechanism], limit: float):
    low, high = mechanisms["drawer_unit"].joints[0].limits or (0.0, 0.0)
    ((_, position),) = state_of(mechanisms["drawer_unit"], drawer_1=limit)
    assert low <= position <= high


@pytest.mark.parametrize("position", [-0.001, 0.2501])
def test_beyond_a_limit_both_bounds_are_told(mechanisms: dict[str, Mechanism], position: float):
    key, finding = finding_of(mechanisms["drawer_unit"], drawer_1=position)
    assert (key, finding.code, finding.value, finding.unit) == ("drawer_1", "scene/joint-range", position, "m")
    assert "0 m and 0.25 m" in finding.headline
    key, finding = finding_of(mechanisms["microwave"], door_deg=120.0)
    assert (key, finding.code, finding.unit) == ("door_deg", "scene/joint-range", "rad")
    assert "0 rad (0 deg) and 1.8 rad (103.1 deg)" in finding.headline
    assert "120 deg" in finding.headline


def test_degrees_in_the_place_of_radians_are_suspected(mechanisms: dict[str, Mechanism]):
    oven = mechanisms["microwave"]
    key, finding = finding_of(oven, door=90.0)
    assert (key, finding.code) == ("door", "scene/degrees-suspected")
    assert "`door_deg: 90`" in finding.headline
    assert finding_of(oven, turn=45.0)[1].code == "scene/degrees-suspected"
    assert finding_of(oven, door=200.0)[1].code == "scene/joint-range"  # nor are 200 degrees within the limits
    assert state_of(oven, turn=6.0) == (("turn", 6.0),)


def test_an_unknown_joint_gets_the_nearest_name_and_a_list(mechanisms: dict[str, Mechanism]):
    key, finding = finding_of(mechanisms["drawer_unit"], drawer1=0.1)
    assert (key, finding.code) == ("drawer1", "scene/unknown-joint")
    assert "did you mean `drawer_1`?" in finding.headline
    assert "drawer_1, drawer_2" in finding.headline
    assert "no joints" in finding_of(None, door=0.1)[1].headline


def test_a_slide_takes_no_degrees_and_a_joint_one_position(mechanisms: dict[str, Mechanism]):
    assert finding_of(mechanisms["drawer_unit"], drawer_1_deg=5.0)[1].code == "scene/invalid-value"
    assert finding_of(mechanisms["microwave"], door=0.5, door_deg=5.0)[1].code == "scene/given-twice"


def test_what_follows_cannot_be_written(mechanisms: dict[str, Mechanism]):
    _, finding = finding_of(mechanisms["chest"], latch=0.01)
    assert (finding.code, finding.bound) == ("scene/joint-follows", "lid")
    assert finding_of(mechanisms["four_bar"], closing=0.1)[1].code == "scene/joint-follows"


def test_a_follower_stays_within_its_limits(mechanisms: dict[str, Mechanism]):
    chest = mechanisms["chest"]
    lid, latch = chest.joints
    short = replace(chest, joints=(lid, replace(latch, limits=(0.0, 0.01))))
    assert state_of(short, lid=0.99) == (("lid", 0.99),)
    key, finding = finding_of(short, lid=1.5)
    assert (key, finding.code, finding.value) == ("lid", "scene/joint-range", pytest.approx(0.015))
    assert "`latch`" in finding.headline


def test_a_loop_must_close(mechanisms: dict[str, Mechanism]):
    _, finding = finding_of(mechanisms["four_bar"], left=0.4)
    assert finding.code == "scene/joint-loop"
    assert isinstance(finding.value, float)
    assert finding.value > 0.02
    # A parallelogram: both arms turn alike, and the bar stays level.
    assert len(state_of(mechanisms["four_bar"], left=0.4, right=0.4, bar=-0.4)) == 3


def test_a_ball_joint_has_no_position(mechanisms: dict[str, Mechanism]):
    oven = mechanisms["microwave"]
    door, turn = oven.joints
    _, finding = finding_of(replace(oven, joints=(replace(door, kind="ball"), turn)), door=0.1)
    assert finding.code == "scene/unknown-joint"
