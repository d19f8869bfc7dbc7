"""Read a URDF as the links of a robot (m, rad): wiki.ros.org/urdf/XML. Every link is kept; mimic joints too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from geom.pose import apply, pose
from replay.recording.episode import JointKind, Link
from replay.recording.mjcf.text import numbers, parse_xml
from replay.recording.recorded_numbers import invalid_recording
from replay.recording.shapes import hull, locate_mesh, mesh_points
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape

_KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
_NONE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RobotModel:
    """Links, parents first, and the names of the coordinates that drive them, in the order of the file."""

    links: tuple[Link, ...]
    coordinates: tuple[str, ...]


def read_urdf(
    path: Path, root: Path, meshes: Path | None = None, measured: Callable[[str], bool] = lambda joint: False
) -> RobotModel:
    """The robot of a file; its meshes from its folder, else from `meshes`.

    A mimic joint that was recorded itself (`measured`) follows its record: many engines and grippers do not keep the
    fingers as equal as the file states. Raises InvalidInput.
    """
    robot, file = parse_xml(path, root), path.name
    if robot.tag != "robot":
        raise invalid_recording("replay/invalid-value", f"the root element is <{robot.tag}>, not <robot>", file)
    joints = {j.get("name", ""): j for j in robot.findall("joint")}
    for name, joint in joints.items():
        if joint.get("type") not in _KINDS:
            message = f"joint '{name}' is of type '{joint.get('type')}': not read"
            raise invalid_recording("replay/unsupported-model", message, file, joint.sourceline)
    movable = [name for name, joint in joints.items() if _KINDS[joint.get("type")] != "fixed"]
    driven = [name for name in movable if joints[name].find("mimic") is None or measured(name)]
    order = _order(robot, joints, file)
    number_of = {link: number for number, (link, _) in enumerate(order)}
    elements = {link.get("name", ""): link for link in robot.findall("link")}
    links: list[Link] = []
    moves: set[str] = set()
    for name, joint_name in order:
        joint = joints.get(joint_name)
        kind = _KINDS[joint.get("type")] if joint is not None else "fixed"
        parent = _end(joint, "parent") if joint is not None else ""
        if kind != "fixed" or parent in moves:
            moves.add(name)
        coordinate, gain, offset = _drive(joint_name, joints, driven, file) if kind != "fixed" else (-1, 1.0, 0.0)
        links.append(
            Link(
                name,
                number_of.get(parent, -1),
                kind,
                _axis(joint, file),
                _origin(joint, file),
                coordinate,
                gain,
                offset,
                _shapes(elements[name], name in moves, path.parent, meshes, file),
            )
        )
    return RobotModel(tuple(links), tuple(driven))


def _order(robot: Any, joints: dict[str, Any], file: str) -> list[tuple[str, str]]:
    """Links with the joint that carries them, parents first; the root has none."""
    below: dict[str, list[tuple[str, str]]] = {}
    for name, joint in joints.items():
        below.setdefault(_end(joint, "parent"), []).append((_end(joint, "child"), name))
    names = [link.get("name", "") for link in robot.findall("link")]
    children = [child for some in below.values() for child, _ in some]
    roots = [name for name in names if name not in children]
    order = [(root, "") for root in roots]
    for link, _ in order:
        order += below.get(link, [])
        if len(order) > len(names):
            break
    if len(roots) != 1 or sorted(link for link, _ in order) != sorted(names):
        message = f"the links are no tree: {len(roots)} roots, {len(joints)} joints, {len(names)} links"
        raise invalid_recording("replay/invalid-value", message, file)
    return order


def _end(joint: Any, tag: str) -> str:
    element = joint.find(tag)
    return element.get("link", "") if element is not None else ""


def _drive(name: str, joints: dict[str, Any], driven: list[str], file: str) -> tuple[int, float, float]:
    """Coordinate, gain and offset of a movable joint, through joints that it mimics."""
    gain, offset = 1.0, 0.0
    for _ in joints:
        mimic = joints[name].find("mimic") if name in joints else None
        if mimic is None or name in driven:
            break
        a = dict(mimic.attrib)
        offset += gain * numbers(a, "offset", 1, (0.0,), file)[0]
        gain *= numbers(a, "multiplier", 1, (1.0,), file)[0]
        name = a.get("joint", "")
    if name not in driven:
        raise invalid_recording("replay/invalid-value", f"a mimic joint follows '{name}', which drives nothing", file)
    return driven.index(name), gain, offset


def _axis(joint: Any, file: str) -> FloatArray:
    if joint is None or joint.get("type") == "fixed":  # Some files have an axis of zeros there.
        return np.array([0.0, 0.0, 1.0])
    element = joint.find("axis")
    axis = np.array(numbers(dict(element.attrib), "xyz", 3, None, file) if element is not None else (1.0, 0.0, 0.0))
    if not np.linalg.norm(axis) > 1e-12:
        raise invalid_recording(
            "replay/invalid-value", f"joint '{joint.get('name')}' has no axis", file, joint.sourceline
        )
    return axis / np.linalg.norm(axis)


def _origin(element: Any, file: str) -> FloatArray:
    """X (4, 4) of its `<origin>`; rpy turn about fixed axes x, y, z."""
    origin = element.find("origin") if element is not None else None
    a = dict(origin.attrib) if origin is not None else {}
    R = Rotation.from_euler("xyz", numbers(a, "rpy", 3, _NONE, file)).as_matrix()
    return pose(R, np.array(numbers(a, "xyz", 3, _NONE, file)))


def _shapes(link: Any, moves: bool, folder: Path, meshes: Path | None, file: str) -> tuple[CollisionShape, ...]:
    """Collision shapes; the visuals of a link that moves and has none."""
    elements = link.findall("collision") or (link.findall("visual") if moves else [])
    shapes = (_shape(element, link.get("name", ""), folder, meshes, file) for element in elements)
    return tuple(shape for shape in shapes if shape is not None)


def _shape(element: Any, link: str, folder: Path, meshes: Path | None, file: str) -> CollisionShape | None:
    X, geometry = _origin(element, file), element.find("geometry")
    kind = next(iter(geometry), None) if geometry is not None else None
    if kind is None:
        return None
    a = dict(kind.attrib)
    if kind.tag == "box":
        return CollisionShape("box", _sizes(a, "size", 3, link, file), X)
    if kind.tag == "sphere":
        return CollisionShape("sphere", _sizes(a, "radius", 1, link, file), X)
    if kind.tag in ("cylinder", "capsule"):
        size = (*_sizes(a, "radius", 1, link, file), *_sizes(a, "length", 1, link, file))
        return CollisionShape(kind.tag, size, X)
    if kind.tag != "mesh":
        raise invalid_recording(
            "replay/unsupported-model", f"<{kind.tag}> of link '{link}' is not read", file, kind.sourceline
        )
    path = locate_mesh(a.get("filename", ""), folder, meshes, file)
    return hull(apply(X, mesh_points(path, numbers(a, "scale", 3, (1.0, 1.0, 1.0), file), file)), link, file)


def _sizes(a: dict[str, str], name: str, count: int, link: str, file: str) -> tuple[float, ...]:
    """Positive numbers. Raises InvalidInput."""
    sizes = numbers(a, name, count, None, file)
    if min(sizes) <= 0.0:
        raise invalid_recording("replay/invalid-value", f"a shape of link '{link}' has {name}='{a[name]}'", file)
    return sizes
