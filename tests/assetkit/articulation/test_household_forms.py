"""Forms of household things that drawn mechanisms of one kind do not show: groups by geometry alone, no names."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from assetkit.stage import LinkSurface
from geom.pose import rotation_about
from schemas.articulation import JointUse
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from tests.support.mechanism.drawn_mechanisms import DrawnMechanism, box, built, open_case, rod, solid_of, tray


def uses_of(drawn: DrawnMechanism) -> tuple[JointUse, ...]:
    return joint_uses(ArticulatedObject(drawn.mechanism, drawn.links))


def door_in_frame() -> DrawnMechanism:
    frame = box((-0.5, -0.06, 0), (0.5, 0.06, 2.1)) - box((-0.44, -1, -0.1), (0.44, 1, 2.04))
    leaf = [box((-0.43, -0.02, 0.01), (0.43, 0.02, 2.03)), rod((0.36, -0.07, 1.0), (0.36, 0.07, 1.0), 0.01)]
    leaf += [rod((0.36, y, 1.0), (0.24, y, 1.0), 0.01) for y in (-0.07, 0.07)]
    return built("hinged_door", solid_of(frame), solid_of(*leaf), "revolute", (-0.43, -0.02, 1), (0, 0, -1), (0, 1.6))


def oven_door() -> DrawnMechanism:
    case, leaf = open_case(0.6, 0.6, 0.6, 0.03), box((-0.29, -0.34, 0.04), (0.29, -0.3, 0.58))
    return built("hinged_door", solid_of(case), solid_of(leaf), "revolute", (0, -0.3, 0.04), (1, 0, 0), (0, 1.5))


def flap() -> DrawnMechanism:
    case, leaf = open_case(0.6, 0.6, 0.6, 0.03), box((-0.29, -0.34, 0.04), (0.29, -0.3, 0.58))
    return built("hinged_lid", solid_of(case), solid_of(leaf), "revolute", (0, -0.3, 0.58), (-1, 0, 0), (0, 1.5))


def pump_bottle() -> DrawnMechanism:
    bottle = [rod((0, 0, 0), (0, 0, 0.15), 0.035), rod((0, 0, 0.15), (0, 0, 0.17), 0.015)]
    head = [rod((0, 0, 0.15), (0, 0, 0.2), 0.006), rod((0, 0, 0.2), (0, 0, 0.215), 0.015)]
    head.append(rod((0, 0, 0.208), (0, 0.045, 0.208), 0.006))
    return built("button", solid_of(*bottle), solid_of(*head), "prismatic", (0, 0, 0.2), (0, 0, -1), (0, 0.015))


def toggle_switch() -> DrawnMechanism:
    plate, arm = box((-0.04, 0, 0), (0.04, 0.01, 0.12)), rod((0, 0, 0.06), (0, -0.025, 0.07), 0.004)
    return built("lever", solid_of(plate), solid_of(arm), "revolute", (0, 0, 0.06), (-1, 0, 0), (0, 0.6))


def valve() -> DrawnMechanism:
    ring = Manifold.cylinder(0.02, 0.05, 0.05, 48) - Manifold.cylinder(0.03, 0.04, 0.04, 48).translate([0, 0, -0.005])
    spokes = [box((-0.045, -0.006, 0), (0.045, 0.006, 0.015)), box((-0.006, -0.045, 0), (0.006, 0.045, 0.015))]
    wheel = (ring + spokes[0] + spokes[1] + rod((0, 0, -0.04), (0, 0, 0.01), 0.006)).translate([0, 0, 0.12])
    pipe = [rod((-0.2, 0, 0.04), (0.2, 0, 0.04), 0.03), rod((0, 0, 0.04), (0, 0, 0.09), 0.02)]
    return built("knob", solid_of(*pipe), solid_of(wheel), "revolute", (0, 0, 0.1), (0, 0, 1), (0, 6.0))


def laptop_open_at_rest() -> DrawnMechanism:
    screen = solid_of(box((-0.15, -0.1, 0.016), (0.15, 0.1, 0.024)))
    R, hinge = rotation_about((-1.0, 0.0, 0.0), math.radians(110)), np.array([0.0, 0.1, 0.0155])
    raised = replace(screen, points=(screen.points - hinge) @ R.T + hinge)
    limits = (-math.radians(110), 0.0)
    base = solid_of(box((-0.15, -0.1, 0), (0.15, 0.1, 0.015)))
    return built("folding", base, raised, "revolute", hinge.tolist(), (-1, 0, 0), limits)


def pull_out_pantry() -> DrawnMechanism:
    case, inner = open_case(0.2, 0.6, 1.6, 0.015), tray((-0.08, -0.3, 0.03), (0.08, 0.27, 1.5), 0.01)
    return built("drawer", solid_of(case), solid_of(inner), "prismatic", (0, 0, 0.8), (0, -1, 0), (0, 0.5))


def window_sash() -> DrawnMechanism:
    frame = box((-0.4, 0, 0), (0.4, 0.08, 1.2)) - box((-0.36, -1, 0.04), (0.36, 1, 1.16))
    sash = box((-0.36, 0.02, 0.04), (0.36, 0.05, 0.6))
    return built("sliding_door", solid_of(frame), solid_of(sash), "prismatic", (0, 0, 0.3), (0, 0, 1), (0, 0.5))


FORMS = (
    door_in_frame,
    oven_door,
    flap,
    pump_bottle,
    toggle_switch,
    valve,
    laptop_open_at_rest,
    pull_out_pantry,
    window_sash,
)


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.__name__)
def test_the_group_and_the_shut_end(form) -> None:
    drawn = form()
    (use,) = uses_of(drawn)
    assert use.group.value == drawn.group, use.group
    assert drawn.joint.limits is not None
    assert (use.closed.value, use.open.value) == pytest.approx(drawn.joint.limits)


def test_a_handle_on_both_sides_of_a_door_is_taken_on_the_side_to_which_it_opens() -> None:
    (use,) = uses_of(door_in_frame())
    assert use.contact is not None
    assert use.contact.value.kind == "handle"
    assert use.contact.value.position_m[1] < -0.05


def test_doors_and_a_drawer_of_one_cabinet_open_each_its_own_way() -> None:
    body = open_case(0.6, 0.5, 0.9, 0.02) + box((-0.28, -0.25, 0.6), (0.28, 0.24, 0.62))
    inner = tray((-0.27, -0.25, 0.64), (0.27, 0.2, 0.85), 0.01)
    front = [box((-0.29, -0.27, 0.62), (0.29, -0.25, 0.88)), rod((0, -0.27, 0.75), (0, -0.3, 0.75), 0.012)]
    links = [LinkSurface("b", solid_of(body)), LinkSurface("dr", solid_of(inner, *front))]
    joints = [
        MechanismJoint("d", "prismatic", "b", "dr", np.zeros(3), np.array([0, -1.0, 0]), 0.0, (0.0, 0.4)),
    ]
    for side in (-1, 1):
        leaf = box((min(0, side * 0.29) + 0.002, -0.27, 0.02), (max(0, side * 0.29) - 0.002, -0.25, 0.6))
        links.append(
            LinkSurface(f"l{side}", solid_of(leaf, rod((side * 0.03, -0.27, 0.5), (side * 0.03, -0.3, 0.5), 0.01)))
        )
        limits = (0.0, 1.7) if side > 0 else (-1.7, 0.0)
        anchor = np.array([side * 0.29, -0.26, 0.3])
        joints.append(
            MechanismJoint(f"h{side}", "revolute", "b", f"l{side}", anchor, np.array([0, 0, 1.0]), 0.0, limits)
        )
    bodies = tuple(MechanismLink(s.link, np.zeros(3)) for s in links)
    uses = uses_of(DrawnMechanism("", Mechanism(bodies, tuple(joints)), tuple(links)))
    assert [use.group.value for use in uses] == ["drawer", "hinged_door", "hinged_door"]
    assert [use.open.value for use in uses] == [0.4, -1.7, 1.7]
    assert [use.contact.value.kind for use in uses if use.contact] == ["knob", "knob", "knob"]
    for use in uses:
        assert use.contact is not None
        assert np.array(use.contact.value.pull) @ [0.0, -1.0, 0.0] > 0.9, "out of the front"


def test_a_wheel_on_the_ground_is_no_knob() -> None:
    body, wheel = box((-0.2, -0.1, 0.05), (0.2, 0.1, 0.2)), rod((0.1, -0.12, 0.04), (0.1, -0.1, 0.04), 0.04)
    drawn = built("", solid_of(body), solid_of(wheel), "continuous", (0.1, -0.11, 0.04), (0, 1, 0), None)
    assert uses_of(drawn)[0].group.value == "unknown"


def test_what_passes_through_the_body_is_no_drawer() -> None:
    post, slider = box((0, -0.05, 0), (0.1, 0.05, 0.1)), box((0.1, -0.05, 0), (0.2, 0.05, 0.1))
    drawn = built("", solid_of(post), solid_of(slider), "prismatic", (0, 0, 0), (1, 0, 0), (-0.3, 0.3))
    assert uses_of(drawn)[0].group.value == "unknown"
