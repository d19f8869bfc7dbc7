"""The motion of a hand as data: its rates are those of its places, and a motion of use ends where it began."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from geom.grasp.gripper import MEDIUM
from sim.grasp_trial import GRASP_AND_LIFT, PICK_AND_PLACE, PLACE_M, SWING_RAD, TILT_RAD, HandMotion, Phase
from sim.gripper_description import MOUNT, describe_gripper

R_WG = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
USE = HandMotion(
    (
        (Phase.APPROACH, 0.6),
        (Phase.CLOSE, 0.3),
        (Phase.LIFT, 0.9),
        (Phase.TILT, 4.0),
        (Phase.SWING, 2.2),
        (Phase.STIR, 3.0),
        (Phase.LOWER, 0.9),
    ),
    lift_m=0.7,
    wrist_sense=-1.0,
)


@pytest.mark.parametrize("motion", [GRASP_AND_LIFT, PICK_AND_PLACE, USE])
def test_rates_are_those_of_the_places(motion: HandMotion) -> None:
    ends = [0.0, *(end for _, end in motion.ends())]
    h = 1e-6
    for first, last in pairwise(ends):
        for time_s in np.linspace(first, last, 23)[1:-1]:
            ahead, behind = motion.at(time_s + h, R_WG)[0], motion.at(time_s - h, R_WG)[0]
            assert motion.at(time_s, R_WG)[1] == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-5)


@pytest.mark.parametrize("motion", [GRASP_AND_LIFT, PICK_AND_PLACE, USE])
def test_places_do_not_jump_between_phases(motion: HandMotion) -> None:
    for _, end in motion.ends()[:-1]:
        assert motion.at(end - 1e-7, R_WG)[0] == pytest.approx(motion.at(end + 1e-7, R_WG)[0], abs=1e-5)


def test_the_wrist_turns_to_its_side_and_back_before_the_hand_goes_down() -> None:
    wrist = np.array([USE.at(t, R_WG)[0][4] for t in np.linspace(0.0, 11.9, 2000)])
    assert wrist.max() == pytest.approx(0.0)
    assert wrist.min() == pytest.approx(-TILT_RAD, rel=1e-3)
    ends = dict(USE.ends())
    assert USE.at(0.5 * (ends[Phase.TILT] + ends[Phase.SWING]), R_WG)[0][4] == pytest.approx(-SWING_RAD)
    assert USE.at(11.9, R_WG)[0] == pytest.approx([0.0, 0.0, PLACE_M, 0.0, 0.0], abs=1e-6)
    assert USE.at(ends[Phase.TILT], R_WG)[0][2] == pytest.approx(0.7)


def test_only_a_hand_that_turns_has_a_wrist() -> None:
    assert not PICK_AND_PLACE.turns_wrist
    assert USE.turns_wrist
    names = [
        {joint.name for joint in describe_gripper(MEDIUM, 0.06, R_WG, turns_wrist=turns).joints}
        for turns in (False, True)
    ]
    assert names[1] - names[0] == {MOUNT[-1]}
