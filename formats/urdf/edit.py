"""Changes numbers of a URDF file of one link; everything else stays as it is, comments apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from formats.urdf.read import PROXIMITY
from formats.urdf.write import contact_element, friction_element, inertial_element
from formats.xml_elements import parse_file
from formats.xml_text import to_bytes
from schemas.robot_description import Inertial, ShapeFriction


def replace_physics(
    path: Path, inertial: Inertial, contact: Mapping[str, float], frictions: Sequence[ShapeFriction] = ()
) -> bytes:
    """The file with another `<inertial>` and `<contact>` of its first link.

    Collisions that state a friction of their own take that of `frictions`, in their order. Raises ValueError for a file
    without a link, InvalidInput for one that is no XML.
    """
    robot = parse_file(path, path.parent)
    link = robot.first("link")
    if link is None:
        raise ValueError(f"{path.name} has no link")
    others = [child for child in link.children if child.tag not in ("contact", "inertial")]
    link.children = [contact_element(contact), inertial_element(inertial), *others]
    for collision, friction in zip(link.named("collision"), frictions, strict=False):
        collision.children = [
            friction_element(friction) if child.tag == PROXIMITY else child for child in collision.children
        ]
    return to_bytes(robot)
