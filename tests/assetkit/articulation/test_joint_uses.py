"""Uses of joints by geometry: groups, opening and contacts of drawn mechanisms, in any heading, by any names."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from geom.mechanism_pose import joint_motion
from geom.mesh.surface_distance import NearestOnSurface
from geom.pose import rotation_about
from schemas.articulation import JointUse
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from tests.support.mechanism.drawn_mechanisms import (
    DrawnMechanism,
    box,
    built,
    button,
    drawer,
    folding,
    hinged_door,
    hinged_lid,
    knob,
    lever,
    sliding_door,
    solid_of,
    transformed,
    turntable,
)

NONSENSE = ("zq1", "vr2", "xk3")


def shares(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high)


drawers = st.builds(
    drawer, shares(0.3, 0.8), shares(0.3, 0.6), shares(0.12, 0.4), handle=st.booleans(), travel=shares(0.5, 0.95)
)
doors = st.builds(
    hinged_door,
    shares(0.3, 0.8),
    shares(0.2, 0.6),
    shares(0.3, 1.8),
    handle=st.booleans(),
    turn=shares(1.0, 2.8),
    left=st.booleans(),
)
lids = st.builds(hinged_lid, shares(0.2, 0.6), shares(0.2, 0.5), shares(0.1, 0.4), turn=shares(1.0, 2.2))
sliding = st.builds(sliding_door, shares(0.6, 1.5), shares(0.2, 0.5), shares(0.5, 1.8))
knobs = st.builds(knob, shares(0.15, 0.6), shares(0.05, 0.12), shares(0.6, 2.0), turn=st.none() | shares(1.5, 5.0))
buttons = st.builds(button, shares(0.1, 0.4), shares(0.05, 0.12), shares(0.2, 0.9))
levers = st.builds(lever, shares(0.1, 0.4), shares(0.4, 0.9), turn=shares(0.4, 2.2))
turntables = st.builds(turntable, shares(0.2, 0.5), shares(0.5, 1.0))
halves = st.builds(folding, shares(0.25, 0.4), shares(0.18, 0.3), shares(0.02, 0.06))
mechanisms = st.one_of(drawers, doors, lids, sliding, knobs, buttons, levers, turntables, halves)


def use_of(drawn: DrawnMechanism) -> JointUse:
    (use,) = joint_uses(ArticulatedObject(drawn.mechanism, drawn.links))
    return use


@settings(max_examples=36, deadline=None)
@given(mechanisms)
def test_geometry_alone_tells_the_group_and_how_it_opens(drawn: DrawnMechanism) -> None:
    use = use_of(drawn)
    assert use.group.value == drawn.group, use.group
    assert use.group.confidence < 0.8, "no names: geometry alone is never sure"
    if drawn.joint.limits is not None:
        assert (use.closed.value, use.open.value) == pytest.approx(drawn.joint.limits)
        assert min(use.closed.confidence, use.open.confidence) >= 0.5
    else:
        assert use.open.confidence == 0.0, "which way it turns is not known"


@settings(max_examples=18, deadline=None)
@given(mechanisms, st.floats(-math.pi, math.pi), st.booleans(), st.sampled_from([-0.3, 0.0, 1.7]), st.just(NONSENSE))
def test_heading_axis_zero_and_names_change_nothing(
    drawn: DrawnMechanism, yaw: float, reverse: bool, zero: float, names: tuple[str, str, str]
) -> None:
    other = transformed(drawn, yaw=yaw, reverse=reverse, zero=zero, names=names)
    before, after = use_of(drawn), use_of(other)
    assert after.group.value == before.group.value
    assert after.group.confidence == pytest.approx(before.group.confidence, abs=0.01)
    if before.open.confidence > 0.0:
        assert after.sense == (-before.sense if reverse else before.sense)
        assert after.closed.value == pytest.approx(
            -before.closed.value + zero if reverse else before.closed.value + zero
        )
    R = rotation_about((0.0, 0.0, 1.0), yaw)
    if drawn.group in ("drawer", "hinged_door", "hinged_lid", "sliding_door", "button"):
        here, there = before.contact, after.contact
        assert here is not None
        assert there is not None
        assert here.value.kind == there.value.kind
        assert R @ np.array(here.value.pull) == pytest.approx(np.array(there.value.pull), abs=0.05)
        assert R @ np.array(here.value.normal) == pytest.approx(np.array(there.value.normal), abs=0.02)


@settings(max_examples=18, deadline=None)
@given(mechanisms, st.booleans())
def test_the_pull_is_the_way_on_which_the_contact_moves_first(drawn: DrawnMechanism, reverse: bool) -> None:
    drawn = transformed(drawn, yaw=0.4, reverse=reverse, zero=0.0, names=NONSENSE)
    use = use_of(drawn)
    assert use.contact is not None
    contact, step = use.contact.value, 1e-6 * use.sense
    position = np.array(contact.position_m)
    moved = joint_motion(drawn.joint, step) @ np.array([*position, 1.0])
    way = moved[:3] - position
    assert way / np.linalg.norm(way) == pytest.approx(np.array(contact.pull), abs=1e-3)
    assert np.linalg.norm(contact.normal) == pytest.approx(1.0, abs=1e-6)
    assert (np.array(contact.low_m) <= position + 1e-6).all()
    assert (position <= np.array(contact.high_m) + 1e-6).all()


@settings(max_examples=12, deadline=None)
@given(st.one_of(drawers, doors), st.data())
def test_a_handle_is_found_where_there_is_one_and_nowhere_else(drawn: DrawnMechanism, data: st.DataObject) -> None:
    points = drawn.links[1].solid.points
    has_handle = len(points) > 40  # a plain leaf or tray has few corners
    contact = use_of(drawn).contact
    assert contact is not None
    assert contact.value.kind == ("handle" if has_handle else "edge")
    if has_handle:
        front = points[:, 1].min()
        assert contact.value.position_m[1] == pytest.approx(front, abs=0.05), "the bar stands out farthest"


@settings(max_examples=8, deadline=None)
@given(drawers, st.floats(0.3, 1.0))
def test_an_object_that_rests_open_is_shut_at_the_other_end(drawn: DrawnMechanism, share: float) -> None:
    """The surfaces at rest are those of the open state; the joint counts from there."""
    joint = drawn.joint
    assert joint.limits is not None
    rest = share * joint.limits[1]
    moved = drawn.links[1]
    out = moved.solid.points + rest * joint.axis
    links = (drawn.links[0], replace(moved, solid=replace(moved.solid, points=out)))
    opened = DrawnMechanism(drawn.group, replace(drawn.mechanism, joints=(replace(joint, rest=rest),)), links)
    use = use_of(opened)
    assert use.group.value == "drawer"
    assert use.closed.value == pytest.approx(0.0, abs=0.1 * joint.limits[1])
    assert use.open.value == pytest.approx(joint.limits[1])
    assert use.closed.confidence <= 0.6, "rest and room disagree"


def test_a_door_that_swings_both_ways_is_shut_in_the_middle() -> None:
    drawn = hinged_door(0.6, 0.1, 1.6, handle=False, turn=1.5, left=True)
    # A frame around the leaf instead of a case in front of it.
    joint = replace(drawn.joint, limits=(-1.5, 1.5))
    use = use_of(DrawnMechanism("hinged_door", replace(drawn.mechanism, joints=(joint,)), drawn.links))
    assert use.closed.value == pytest.approx(0.0, abs=0.15)
    assert abs(use.open.value) == 1.5


def names(link: str, joint: str) -> DrawnMechanism:
    plain = drawer(0.5, 0.4, 0.2, handle=True, travel=0.8)
    return transformed(plain, yaw=0.0, reverse=False, zero=0.0, names=("body", link, joint))


def test_the_place_to_push_lies_on_a_link_whose_edge_is_hollow() -> None:
    """A plate that ends in two prongs: the middle of its outer edge lies between them."""
    plate = [
        box((0.0, -0.1, 0.0), (0.3, 0.1, 0.01)),
        *(box((0.3, y, 0.0), (0.4, y + 0.02, 0.01)) for y in (-0.1, 0.08)),
    ]
    base, fork = solid_of(box((-0.2, -0.1, -0.01), (-0.01, 0.1, 0.02))), solid_of(*plate)
    drawn = built("unknown", base, fork, "revolute", (0.0, 0.0, 0.005), (0.0, -1.0, 0.0), (-0.5, 0.5))
    (use,) = joint_uses(ArticulatedObject(drawn.mechanism, drawn.links))
    assert use.contact is not None
    assert use.contact.value.position_m[0] > 0.25
    nearest = NearestOnSurface(fork.points, fork.triangles)
    position = np.array([use.contact.value.position_m])
    away_m = float(np.linalg.norm(nearest(position)[0] - position))
    assert away_m < 1e-6 or bool(nearest.inside(position)[0])


def test_names_that_agree_make_surer() -> None:
    plain, named = use_of(names("zq", "vr")), use_of(names("upper_drawer", "slide"))
    assert named.group.value == plain.group.value == "drawer"
    assert named.group.confidence > plain.group.confidence + 0.1


@pytest.mark.parametrize(("link", "reason"), [("lift_wheel", "wheel"), ("push_button", "contradicting")])
def test_names_of_something_else_make_it_unknown(link: str, reason: str) -> None:
    use = use_of(names(link, "slide"))
    assert use.group.value == "unknown"
    assert use.group.confidence == 0.0
    assert reason in use.group.method


def test_words_of_other_joint_types_are_no_words() -> None:
    """A knob that its author calls a button cannot be pressed."""
    plain = knob(0.4, 0.08, 1.5, turn=2.0)
    use = use_of(transformed(plain, yaw=0.0, reverse=False, zero=0.0, names=("stove", "button", "button")))
    assert use.group.value == "knob"


def test_a_chain_of_three_joints_is_no_household_thing() -> None:
    """The last link of an arm looks like a lever or a knob."""
    arm = lever(0.3, 0.8, turn=2.0)
    links, joints = list(arm.links), list(arm.mechanism.joints)
    bodies = list(arm.mechanism.links)
    for k in range(2):
        last = links[-1]
        tip = last.solid.points[:, 0].max()
        shifted = replace(last.solid, points=last.solid.points + np.array([0.24, 0.0, 0.0]))
        links.append(replace(last, link=f"more_{k}", solid=shifted))
        anchor = np.array([tip, -0.045, 0.21])
        bodies.append(MechanismLink(f"more_{k}", anchor))
        parent = joints[-1].child
        joints.append(
            MechanismJoint(f"j{k}", "revolute", parent, f"more_{k}", anchor, joints[0].axis, 0.0, (-1.0, 1.0))
        )
    uses = joint_uses(ArticulatedObject(Mechanism(tuple(bodies), tuple(joints)), tuple(links)))
    assert [use.group.value for use in uses] == ["unknown"] * 3
