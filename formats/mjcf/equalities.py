"""Equalities of an MJCF model that tie one joint to another by a line: they become mimics, the others stay text.

mujoco.readthedocs.io/en/stable/XMLreference.html#equality-joint: y - y0 = a0 + a1 (x - x0) + ... with x0, y0 the
references of the joints. MuJoCo keeps it as a soft constraint, a mimic is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from formats.attributes import flag, numbers
from formats.mjcf.defaults import Defaults
from formats.tree import unique_joints
from formats.xml_elements import Element, refuse
from schemas.robot_description import DescribedJoint, Mimic


def with_mimics(
    joints: tuple[DescribedJoint, ...], equalities: Sequence[Element], defaults: Defaults
) -> tuple[tuple[DescribedJoint, ...], list[Element]]:
    """The joints with their mimics, and the equalities that are none.

    Raises InvalidInput (`robot/unknown-reference`, `robot/duplicate-name`, `robot/invalid-number`).
    """
    by_name = unique_joints(joints)
    mimics: dict[str, Mimic] = {}
    unread: list[Element] = []
    for element in equalities:
        mimic = _mimic(element, by_name, defaults) if element.tag == "joint" else None
        follower = element.get("joint1")
        if mimic is None or follower in mimics or _follows(mimic.joint, follower, mimics):
            unread.append(element)
        else:
            mimics[follower] = mimic
    return tuple(replace(j, mimic=mimics[j.name]) if j.name in mimics else j for j in joints), unread


def _mimic(element: Element, by_name: dict[str, DescribedJoint], defaults: Defaults) -> Mimic | None:
    """The line by which `joint1` follows `joint2`; None for another curve, an inactive equality, or a ball joint."""
    a = defaults.attributes(element, "")
    pair = [by_name.get(a.get(key, "")) for key in ("joint1", "joint2") if a.get(key)]
    if None in pair:
        lost = next(a[key] for key in ("joint1", "joint2") if a.get(key) and a[key] not in by_name)
        refuse("robot/unknown-reference", f"an equality names the unknown joint '{lost}'", element.source, value=lost)
    joints = [joint for joint in pair if joint is not None]
    curve = numbers(a, "polycoef", None, (0.0, 1.0), element.source)
    single = all(joint.kind in ("revolute", "continuous", "prismatic") for joint in joints)
    if len(joints) < 2 or not single or any(curve[2:]) or not flag(a, "active", True, element.source):
        return None
    follower, leader = joints
    constant, slope = (*curve, 0.0, 0.0)[:2]
    return Mimic(leader.name, slope, follower.reference + constant - slope * leader.reference)


def _follows(joint: str, leader: str, mimics: dict[str, Mimic]) -> bool:
    """Whether `joint` is `leader` or follows it through mimics."""
    while joint != leader and joint in mimics:
        joint = mimics[joint].joint
    return joint == leader
