"""What the uses of joints give the rest of the record: roles, affordance regions and labels of nameless grips."""

from __future__ import annotations

import numpy as np
import pytest

from assetkit.affordances.joint_regions import joint_regions
from assetkit.articulation.grip_parts import label_grips
from assetkit.articulation.interaction_group import tasks
from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from assetkit.articulation.roles import group_of_joints, roles_of_joints
from schemas.affordances import WHOLE
from schemas.evidence import Evidence, default, inferred, measured
from schemas.parts import UNLABELLED, Part, part_faces
from tests.support.mechanism.drawn_mechanisms import DrawnMechanism, button, drawer, hinged_door, knob


def uses_of(drawn: DrawnMechanism):
    return joint_uses(ArticulatedObject(drawn.mechanism, drawn.links))


DRAWER = drawer(0.5, 0.4, 0.2, handle=True, travel=0.8)


def part(low, high, label: Evidence[str], link: str = "moved", number: int = 0) -> Evidence[Part]:
    region = Part(
        part_id=f"part_{number}",
        label=label,
        name="box_3",
        sources=("component",),
        faces=(part_faces("mesh", [number]),),
        triangles=1,
        area_m2=1.0 + number,
        low_m=low,
        high_m=high,
        link=link,
    )
    return measured(region, "drawn", confidence=0.5)


@pytest.mark.parametrize(
    ("drawn", "role"),
    [
        (DRAWER, "openable"),
        (knob(0.3, 0.08, 1.0, turn=3.0), "turnable"),
        (button(0.3, 0.08, 0.5), "pressable"),
    ],
)
def test_a_known_group_gives_a_role_and_a_region(drawn: DrawnMechanism, role: str) -> None:
    (use,) = uses_of(drawn)
    (given,) = roles_of_joints((use,))
    assert given.value == role
    assert given.confidence == use.group.confidence
    (region,) = joint_regions((use,))
    assert use.contact is not None
    assert region.value.joint == use.joint
    assert region.value.kind == use.contact.value.kind
    assert region.value.task == use.task
    assert region.confidence <= min(use.group.confidence, use.contact.confidence)


def test_an_unknown_group_gives_neither() -> None:
    (use,) = uses_of(DRAWER)
    unknown = use.model_copy(update={"group": default("unknown")})
    assert roles_of_joints((unknown,)) == ()
    assert joint_regions((unknown,)) == ()


def test_doors_are_pulled_and_buttons_pushed() -> None:
    door = hinged_door(0.5, 0.3, 0.8, handle=True, turn=1.6, left=True)
    how = [joint_regions(uses_of(drawn))[0].value.interaction for drawn in (door, button(0.3, 0.08, 0.5))]
    assert how == ["pull", "push"]


def test_every_group_has_one_task() -> None:
    assert set(tasks().values()) == {"open", "turn", "press"}
    assert len(tasks()) == 9


def test_a_nameless_bar_becomes_the_handle_of_its_joint() -> None:
    (use,) = uses_of(DRAWER)
    assert use.contact is not None
    box = use.contact.value
    nameless = default(UNLABELLED)
    parts = (
        part(box.low_m, box.high_m, nameless),
        part(box.low_m, box.position_m, nameless, number=1),
        part((-0.3, -0.3, 0.0), (0.3, 0.3, 0.3), nameless, number=2),  # the whole drawer
        part(box.low_m, box.high_m, inferred("door", "name", 0.8), number=3),
        part(box.low_m, box.high_m, nameless, link="body", number=4),
    )
    labelled, (named,) = label_grips(parts, (use,))
    assert [p.value.label.value for p in labelled] == ["handle", "handle", UNLABELLED, "door", UNLABELLED]
    assert labelled[0].value.label.confidence == use.contact.confidence
    assert named.contact is not None
    assert named.contact.value.part == "part_1", "the one with more surface"
    assert joint_regions((use,))[0].value.part == WHOLE
    assert joint_regions((named,))[0].value.part == "part_1"
    assert np.array(named.contact.value.low_m) == pytest.approx(np.array(box.low_m))


def test_the_object_is_of_the_group_of_most_of_its_joints() -> None:
    (slides,), (turns,) = uses_of(DRAWER), uses_of(knob(0.3, 0.08, 1.0, turn=3.0))
    surest = turns.model_copy(update={"group": inferred("knob", "drawn", 0.99)})
    unsure = turns.model_copy(update={"group": default("unknown")})
    for uses, group in (((slides, surest, slides), "drawer"), ((slides, surest), "knob"), ((slides, unsure), "drawer")):
        given = group_of_joints(uses)
        assert given is not None
        assert given.value == group
        assert given.confidence == max(u.group.confidence for u in uses if u.group.value == group)
    assert group_of_joints((unsure,)) is None
