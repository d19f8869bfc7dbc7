import numpy as np
import pytest

from assetkit.up_axis import TO_Z_UP, decide_up_axis
from schemas.evidence import declared, default


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_rotations_bring_the_axis_up_and_keep_handedness(axis: str):
    R = TO_Z_UP[axis]  # pyright: ignore[reportArgumentType]
    assert np.array_equal(R @ np.eye(3)["xyz".index(axis)], [0, 0, 1])
    assert np.linalg.det(R) == 1.0
    assert np.array_equal(R @ R.T, np.eye(3))


@pytest.mark.parametrize("comment", ["exported y-up", "Y Up", "up axis: y", "y is up", "up=+y"])
def test_comment_overrules_a_habit(comment: str):
    decision = decide_up_axis(default("z"), (comment,))
    assert decision.axis.value == "y"
    assert decision.axis.source == "inferred"
    assert [r.name for r in decision.repairs] == ["up_axis_y"]


def test_declared_axis_is_never_overruled():
    decision = decide_up_axis(declared("z", "USD"), ("exported y-up",))
    assert decision.axis.value == "z"
    assert decision.repairs == ()


@pytest.mark.parametrize("comment", ["made in group y", "setup z", "x-up or y-up", ""])
def test_unclear_comments_are_no_evidence(comment: str):
    assert decide_up_axis(default("z"), (comment,)).axis.source == "default"
