"""The moving structure of a description: welds, rest state, joints to the world, and what no package can hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from formats import link_poses, read_mjcf, read_urdf
from formats.mechanism import MAX_LINKS, MechanismReading, read_mechanism
from geom.mechanism_pose import link_frames
from schemas.diagnostics import InvalidInput
from schemas.robot_description import RobotDescription
from tests.support.bad_inputs.robot import joint, link, mjcf, shape, urdf, write
from tests.support.present import present

BOX = shape('<box size="1 1 1"/>')
LIMIT = '<limit lower="{}" upper="{}"/>'


def description_of(files: dict[str, str], folder: Path) -> RobotDescription:
    path = write(files, folder)
    return (read_urdf if path.suffix == ".urdf" else read_mjcf)(path)


def reading_of(files: dict[str, str], folder: Path) -> MechanismReading:
    description = description_of(files, folder)
    return read_mechanism(description, [link.name for link in description.links if link.shapes])


def refusal_of(files: dict[str, str], folder: Path) -> str:
    with pytest.raises(InvalidInput) as refused:
        reading_of(files, folder)
    assert refused.value.diagnostic.where.file
    return refused.value.diagnostic.code


def test_welded_links_are_one_named_after_the_first_that_shows_something(tmp_path: Path) -> None:
    parts = [link("base"), link("body", BOX), link("trim", BOX), link("door", BOX)]
    joints = [
        joint("a", "base", "body", "fixed", '<origin xyz="0 0 1"/>'),
        joint("b", "body", "trim", "fixed"),
        joint("c", "trim", "door", "revolute", LIMIT.format(0, 1) + '<origin xyz="1 0 0"/><axis xyz="0 0 2"/>'),
    ]
    reading = reading_of(urdf(*parts, *joints), tmp_path)
    mechanism = present(reading.mechanism)
    assert [(part.name, part.members) for part in mechanism.links] == [
        ("body", ("base", "body", "trim")),
        ("door", ("door",)),
    ]
    (hinge,) = mechanism.joints
    assert (hinge.parent, hinge.child, hinge.kind, hinge.limits) == ("body", "door", "revolute", (0.0, 1.0))
    assert hinge.axis == pytest.approx([0, 0, 1])
    assert hinge.anchor == pytest.approx([1, 0, 1])
    assert reading.link_of == {"base": "body", "body": "body", "trim": "body", "door": "door"}


def test_links_that_do_not_move_are_a_plain_object(tmp_path: Path) -> None:
    fixed = reading_of(urdf(link("a", BOX), link("b", BOX), joint("j", "a", "b", "fixed")), tmp_path)
    assert fixed.mechanism is None
    locked = urdf(link("a", BOX), link("b", BOX), joint("j", "a", "b", "prismatic", LIMIT.format(0.5, 0.5)))
    reading = reading_of(locked, tmp_path)
    assert reading.mechanism is None
    assert [r.name for r in reading.repairs] == ["weld_locked"]
    assert reading.X_ML["b"][:3, 3] == pytest.approx([0.5, 0, 0])  # where it is locked


def test_reversed_limits_are_swapped_and_missing_ones_reported(tmp_path: Path) -> None:
    two = link("a", BOX) + link("b", BOX)
    swapped = reading_of(urdf(two, joint("j", "a", "b", "revolute", LIMIT.format(1, -2))), tmp_path)
    assert present(swapped.mechanism).joints[0].limits == (-2.0, 1.0)
    assert [r.name for r in swapped.repairs] == ["swap_limits"]
    free = reading_of(urdf(two, joint("j", "a", "b", "revolute")), tmp_path)
    assert present(free.mechanism).joints[0].kind == "continuous"
    assert [r.name for r in free.repairs] == ["free_hinge"]


def test_at_rest_joints_stand_within_their_limits_followers_too(tmp_path: Path) -> None:
    three = link("a", BOX) + link("b", BOX) + link("c", BOX)
    lead = joint("lead", "a", "b", "revolute", LIMIT.format(0.5, 2) + '<axis xyz="0 0 1"/>')
    follow = joint(
        "follow",
        "b",
        "c",
        "prismatic",
        LIMIT.format(-9, -2) + '<axis xyz="1 0 0"/><mimic joint="lead" multiplier="-2" offset="-0.6"/>',
    )
    files = urdf(three, lead, follow)
    reading, description = reading_of(files, tmp_path), description_of(files, tmp_path)
    mechanism = present(reading.mechanism)
    rest = {j.name: j.rest for j in mechanism.joints}
    assert rest == pytest.approx({"lead": 0.7, "follow": -2.0})
    expected = link_poses(description, rest)
    assert all(np.allclose(reading.X_ML[name], X) for name, X in expected.items())
    frames = link_frames(mechanism, {"lead": 1.5})
    moved = link_poses(description, {"lead": 1.5})
    for name in ("b", "c"):
        turn = moved[name] @ np.linalg.inv(expected[name])
        rest_frame = np.eye(4)
        rest_frame[:3, 3] = next(part.origin for part in mechanism.links if part.name == name)
        assert frames[name] == pytest.approx(turn @ rest_frame, abs=1e-9)


def test_joints_to_the_world_and_empty_leaves_are_left_out_and_reported(tmp_path: Path) -> None:
    door = '<body name="door"><joint name="h" axis="0 0 1"/><geom size="1"/>{}</body>\n'
    flap = '<body name="flap"><joint name="f"/><geom size="1"/></body><body name="eye"><joint name="e"/></body>'
    reading = reading_of(mjcf(door.format(flap)), tmp_path)
    mechanism = present(reading.mechanism)
    assert [part.name for part in mechanism.links] == ["door", "flap"]
    assert [j.name for j in mechanism.joints] == ["f"]
    assert not mechanism.fixed_base
    assert [n.code for n in reading.notes] == ["robot/empty-link", "robot/base-joint"]
    assert reading_of(mjcf(door.format("")), tmp_path).mechanism is None


@pytest.mark.parametrize(
    ("code", "files"),
    [
        (
            "robot/empty-link",
            urdf(link("a", BOX), link("b"), link("c", BOX), joint("i", "a", "b"), joint("j", "b", "c")),
        ),
        ("robot/empty-link", mjcf('<geom size="1"/><body><joint name="x"/><joint name="y"/><geom size="1"/></body>\n')),
        ("robot/not-expressible", urdf(link("a", BOX), link("b", BOX), joint("j", "a", "b", "planar"))),
        ("robot/several-roots", urdf(link("a", BOX), link("b", BOX), joint("j", "a", "b", "floating"))),
        (
            "robot/too-many-links",
            urdf(
                *(link(f"l{i}", BOX) for i in range(MAX_LINKS + 1)),
                *(joint(f"j{i}", f"l{i}", f"l{i + 1}") for i in range(MAX_LINKS)),
            ),
        ),
    ],
)
def test_what_no_package_can_hold_is_refused(code: str, files: dict[str, str], tmp_path: Path) -> None:
    assert refusal_of(files, tmp_path) == code


def test_names_are_identifiers_and_stay_clear_of_the_scopes_of_a_package(tmp_path: Path) -> None:
    links = link("Joints", BOX) + link("a.b", BOX) + link("a_b", BOX)
    files = urdf(links, joint("j 1", "Joints", "a.b"), joint("j.1", "Joints", "a_b"))
    mechanism = present(reading_of(files, tmp_path).mechanism)
    assert [part.name for part in mechanism.links] == ["Joints_2", "a_b_2", "a_b"]
    assert [j.name for j in mechanism.joints] == ["j_1", "j_1_2"]
    assert [j.source_name for j in mechanism.joints] == ["j 1", "j.1"]
