"""The up axis: declarations are used, statements in texts decide only where the format does not declare one."""

import numpy as np
import pytest

from assetkit.pose.up_axis import TO_Z_UP, decide_up_axis
from schemas.evidence import Evidence, declared, default
from schemas.model import Axis


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_rotations_bring_the_axis_up_and_keep_handedness(axis: Axis):
    R = TO_Z_UP[axis]
    assert np.array_equal(R @ np.eye(3)["xyz".index(axis)], [0, 0, 1])
    assert np.linalg.det(R) == 1.0
    assert np.array_equal(R @ R.T, np.eye(3))


@pytest.mark.parametrize("comment", ["exported y-up", "Y Up", "up axis: y", "y is up", "up=+y"])
def test_comment_overrules_a_habit(comment: str):
    decision = decide_up_axis(default("z"), (comment,))
    assert decision.axis.value == "y"
    assert decision.axis.source == "inferred"
    assert [r.name for r in decision.repairs] == ["up_axis_y"]


def codes(decision):
    return [d.code for d in decision.diagnostics]


def test_declared_axis_is_never_overruled_but_a_contradiction_is_said():
    decision = decide_up_axis(declared("z", "USD"), ("exported y-up",))
    assert decision.axis.value == "z"
    assert decision.axis.confidence < 1.0
    assert decision.repairs == ()
    assert codes(decision) == ["asset/contradictory-evidence"]
    assert not decision.review


def test_declared_axis_that_texts_confirm_needs_no_word():
    decision = decide_up_axis(declared("z", "USD"), ("exported z-up",))
    assert decision.axis.confidence == 1.0
    assert decision.diagnostics == ()


def test_a_text_overrules_what_a_standard_implies():
    silent: Evidence[Axis] = declared("y", "COLLADA default up axis", confidence=0.5)
    assert decide_up_axis(silent, ("z is up",)).axis.value == "z"
    assert decide_up_axis(silent, ()).diagnostics == ()


@pytest.mark.parametrize("texts", [("x-up or y-up",), ("z-up", "exported y-up")])
def test_contradicting_texts_go_to_a_person(texts: tuple[str, ...]):
    decision = decide_up_axis(default("z"), texts)
    assert decision.review
    assert decision.axis.confidence == 0.0
    assert codes(decision) == ["asset/contradictory-evidence"]


def test_a_conversion_names_its_result():
    decision = decide_up_axis(default("z"), ("turned from z-up to y-up",))
    assert decision.axis.value == "y"
    assert not decision.review


@pytest.mark.parametrize("comment", ["made in group y", "setup z", "cup x", ""])
def test_unclear_comments_are_no_evidence_and_the_guess_is_said(comment: str):
    decision = decide_up_axis(default("z"), (comment,))
    assert decision.axis.source == "default"
    assert codes(decision) == ["asset/up-axis-unverified"]


def test_the_user_decides():
    decision = decide_up_axis(declared("y", "glTF"), ("z-up", "x-up"), "x")
    assert (decision.axis.value, decision.axis.source) == ("x", "declared")
    assert decision.diagnostics == ()
