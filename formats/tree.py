"""The tree of a description: its root, or why links and joints are no tree; in time linear in their number."""

from __future__ import annotations

from collections.abc import Sequence

from formats.xml_elements import refuse
from schemas.robot_description import DescribedJoint, DescribedLink, RobotDescription, SourceLine


def root_of(links: Sequence[DescribedLink], joints: Sequence[DescribedJoint], source: SourceLine) -> str:
    """The name of the only link without a parent. Several joints may carry a child if they come from one parent.

    Raises InvalidInput (`robot/no-links`, `robot/duplicate-name`, `robot/missing-link`, `robot/two-parents`,
    `robot/several-roots`, `robot/link-cycle`).
    """
    if not links:
        refuse("robot/no-links", "the description has no link", source)
    by_name = unique_links(links)
    unique_joints(joints)
    carrier: dict[str, DescribedJoint] = {}
    for joint in joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in by_name:
                headline = f"the {end} of joint '{joint.name}' is '{name}', which is no link"
                refuse("robot/missing-link", headline, joint.source, value=name)
        other = carrier.setdefault(joint.child, joint)
        if other.parent != joint.parent or (other is not joint and not (other.stated and joint.stated)):
            headline = f"link '{joint.child}' is the child of joints '{other.name}' and '{joint.name}'"
            refuse("robot/two-parents", headline, joint.source, value=joint.child)
    roots = [link for link in links if link.name not in carrier]
    if len(roots) > 1:
        names = ", ".join(f"'{link.name}'" for link in roots[:5]) + (", ..." if len(roots) > 5 else "")
        refuse("robot/several-roots", f"{len(roots)} links have no parent: {names}", roots[1].source, len(roots), 1)
    lost = _unreached(roots, by_name, carrier)
    if lost:
        cycle = _cycle(lost[0], carrier)
        refuse("robot/link-cycle", f"links form a cycle: {' -> '.join(cycle[:8])}", by_name[lost[0]].source, lost[0])
    return roots[0].name


def unique_links(links: Sequence[DescribedLink]) -> dict[str, DescribedLink]:
    """Links by name. Raises InvalidInput `robot/duplicate-name`."""
    by_name: dict[str, DescribedLink] = {}
    for link in links:
        other = by_name.setdefault(link.name, link)
        if other is not link:
            headline = f"two links are called '{link.name}'; the other is in line {other.source.line}"
            refuse("robot/duplicate-name", headline, link.source, value=link.name)
    return by_name


def unique_joints(joints: Sequence[DescribedJoint]) -> dict[str, DescribedJoint]:
    """Joints by name. Raises InvalidInput `robot/duplicate-name`."""
    by_name: dict[str, DescribedJoint] = {}
    for joint in joints:
        other = by_name.setdefault(joint.name, joint)
        if other is not joint:
            headline = f"two joints are called '{joint.name}'; the other is in line {other.source.line}"
            refuse("robot/duplicate-name", headline, joint.source, value=joint.name)
    return by_name


def joints_below(joints: Sequence[DescribedJoint]) -> dict[str, list[DescribedJoint]]:
    """Joints by the name of their parent, in the order of the file."""
    below: dict[str, list[DescribedJoint]] = {}
    for joint in joints:
        below.setdefault(joint.parent, []).append(joint)
    return below


def joints_of(joints: Sequence[DescribedJoint]) -> dict[str, list[DescribedJoint]]:
    """Joints by the name of the child that they carry, in the order in which they act."""
    of_child: dict[str, list[DescribedJoint]] = {}
    for joint in joints:
        of_child.setdefault(joint.child, []).append(joint)
    return of_child


def breadth_first(description: RobotDescription) -> list[str]:
    """Names of all links, parents before their children; children of one parent in the order of their joints."""
    below, order = joints_below(description.joints), [description.root]
    for link in order:  # Grows while it is walked.
        order += dict.fromkeys(joint.child for joint in below.get(link, []))
    return order


def check_mimics(joints: Sequence[DescribedJoint]) -> None:
    """Raises InvalidInput for a mimic of a joint that is not there, and for a circle of mimics."""
    by_name = {joint.name: joint for joint in joints}
    ends: set[str] = set()  # Joints from which following mimics comes to an end.
    for joint in joints:
        path: dict[str, None] = {}
        at = joint
        while at.mimic is not None and at.name not in ends:
            path[at.name] = None
            if at.mimic.joint not in by_name:
                headline = f"joint '{at.name}' mimics '{at.mimic.joint}', which is no joint"
                refuse("robot/unknown-reference", headline, at.source, value=at.mimic.joint)
            at = by_name[at.mimic.joint]
            if at.name in path:
                headline = f"joints mimic each other in a circle: {', '.join(path)}"
                refuse("robot/mimic-cycle", headline, joint.source, value=at.name)
        ends.update(path)


def _unreached(
    roots: Sequence[DescribedLink], by_name: dict[str, DescribedLink], carrier: dict[str, DescribedJoint]
) -> list[str]:
    """Links that no path of joints connects with a root, in the order of the file."""
    children: dict[str, list[str]] = {}
    for child, joint in carrier.items():
        children.setdefault(joint.parent, []).append(child)
    waiting = [link.name for link in roots]
    reached = set(waiting)
    while waiting:
        below = children.get(waiting.pop(), [])
        reached.update(below)
        waiting += below
    return [name for name in by_name if name not in reached]


def _cycle(link: str, carrier: dict[str, DescribedJoint]) -> list[str]:
    """Names of links from parent to parent up to the first that comes again."""
    path: dict[str, None] = {}
    while link not in path:
        path[link] = None
        link = carrier[link].parent
    names = list(path)
    return [*names[names.index(link) :], link]
