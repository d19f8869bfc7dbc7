"""Writes measured joint numbers (`<dynamics>`, `<limit>`) into the URDF of a mechanism; everything else stays as is."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from lxml import etree

from jobs.cache import write_atomically
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.measured_physics import MeasuredJoint


def extend_urdf(source: Path, joints: Mapping[str, MeasuredJoint], target: Path) -> None:
    """Write `source` with `joints` to `target`, which may be the same file; files it refers to are found from there.

    `<dynamics>` and `<limit>` are added where they are missing; a continuous joint with limits becomes revolute. Raises
    InvalidInput for a file that is no URDF (`gap/unreadable-subject`) and for a joint it lacks (`gap/unknown-place`).
    """
    where = Location(file=source.name)
    parser = etree.XMLParser(resolve_entities=False, no_network=True)
    try:
        robot = etree.fromstring(source.read_bytes(), parser)
    except etree.XMLSyntaxError as error:
        raise InvalidInput(finding("gap/unreadable-subject", f"{source.name}: {error}", where=where)) from None
    if robot.tag != "robot":
        raise InvalidInput(finding("gap/unreadable-subject", f"{source.name} is no URDF: <{robot.tag}>", where=where))
    by_name = {name: j for j in robot.findall("joint") if (name := j.get("name")) is not None}
    for name, numbers in joints.items():
        if name not in by_name:
            headline = f"the URDF has no joint '{name}'; there are {', '.join(by_name) or 'none'}"
            raise InvalidInput(finding("gap/unknown-place", headline, where=where))
        _write(by_name[name], numbers)
    for file in robot.iter("mesh", "texture"):
        given = file.get("filename", "")
        if given and "://" not in given and not Path(given).is_absolute():
            file.set("filename", os.path.relpath(source.parent / given, target.parent))
    write_atomically(target, etree.tostring(robot, xml_declaration=True, encoding="utf-8"))


def _write(joint: etree._Element, numbers: MeasuredJoint) -> None:
    for tag, keys in (("dynamics", ("friction", "damping")), ("limit", ("lower", "upper", "effort"))):
        stated = {k: v for k in keys if (v := getattr(numbers, k)) is not None}
        if not stated:
            continue
        element = joint.find(tag)
        if element is None:
            element = etree.SubElement(joint, tag)
        for key, value in stated.items():
            element.set(key, repr(value))
    if None not in (numbers.lower, numbers.upper) and joint.get("type") == "continuous":
        joint.set("type", "revolute")
