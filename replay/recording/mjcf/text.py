"""XML of a MuJoCo model file: includes, classes of defaults, number attributes and the spellings of a rotation."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree
from scipy.spatial.transform import Rotation

from geom.pose import matrix_of, pose, shortest_rotation
from replay.recording.recorded_numbers import invalid_recording
from schemas.arrays import FloatArray

MAX_TEXT_BYTES, MAX_INCLUDES = 50_000_000, 64
Attributes = dict[str, str]


def parse_xml(path: Path, root: Path) -> Any:
    """The root element of a file inside the folder `root`. Raises InvalidInput."""
    if not path.resolve().is_relative_to(root.resolve()):
        raise invalid_recording(
            "replay/path-escape", f"'{path.name}' lies outside the folder of the recording", path.name
        )
    try:
        return _element(path.read_bytes(), path.name)
    except OSError as error:
        raise invalid_recording("replay/missing-file", f"'{path.name}': {error.strerror}", path.name) from None


def _element(data: bytes, file: str) -> Any:
    """The root element; entities are not resolved."""
    if len(data) > MAX_TEXT_BYTES:
        raise invalid_recording("replay/unreadable", f"more than {MAX_TEXT_BYTES} bytes", file)
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True)
    try:
        return etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise invalid_recording("replay/unreadable", str(error), file) from None


def parse_mjcf(path: Path, root: Path) -> Any:
    """The `<mujoco>` element with what included files hold in the place of their includes. Raises InvalidInput."""
    return _with_includes(parse_xml(path, root), path, root)


def mjcf_of_text(data: bytes, path: Path) -> Any:
    """The same of text that a recording at `path` holds; it may include files beside. Raises InvalidInput."""
    return _with_includes(_element(data, path.name), path, path.parent)


def _with_includes(top: Any, path: Path, root: Path) -> Any:
    if top.tag != "mujoco":
        raise invalid_recording("replay/invalid-value", f"the root element is <{top.tag}>, not <mujoco>", path.name)
    for _ in range(MAX_INCLUDES):
        include = next(top.iter("include"), None)
        if include is None:
            return top
        parts = list(parse_xml(path.parent / include.get("file", ""), root))
        parent, place = include.getparent(), include.getparent().index(include)
        parent[place : place + 1] = parts
    raise invalid_recording(
        "replay/invalid-value", f"more than {MAX_INCLUDES} includes, or a file includes itself", path.name
    )


def defaults_of(top: Any, file: str) -> dict[str, dict[str, Attributes]]:
    """Attributes by class and element; a class has those of the classes around it. The outermost is `main`."""
    classes: dict[str, dict[str, Attributes]] = {"main": {}}

    def read(element: Any, inherited: dict[str, Attributes], name: str) -> None:
        by_tag = {tag: dict(attributes) for tag, attributes in inherited.items()}
        for child in element:
            if child.tag != "default":
                by_tag[child.tag] = {**by_tag.get(child.tag, {}), **child.attrib}
        classes[name] = by_tag
        for child in element.findall("default"):
            if not child.get("class"):
                raise invalid_recording(
                    "replay/invalid-value", "a class of defaults has no name", file, child.sourceline
                )
            read(child, by_tag, child.get("class"))

    for element in top.findall("default"):
        read(element, classes["main"], "main")
        if element.get("class"):
            classes[element.get("class")] = classes["main"]
    return classes


def numbers(
    attributes: Attributes, name: str, count: int, default: tuple[float, ...] | None, file: str
) -> tuple[float, ...]:
    """The numbers of an attribute. Raises InvalidInput unless there are `count` finite ones."""
    text = attributes.get(name)
    if text is None and default is not None:
        return default
    try:
        values = tuple(float(word) for word in (text or "").replace(",", " ").split())
    except ValueError:
        values = ()
    if len(values) != count or not np.isfinite(values).all():
        raise invalid_recording("replay/invalid-value", f"{name}='{text}' should be {count} finite numbers", file)
    return values


@dataclass(frozen=True)
class Orientations:
    """How a file writes rotations: angles in degrees or radians, and the order of Euler angles."""

    degrees: bool
    sequence: str
    file: str

    def pose(self, a: Attributes) -> FloatArray:
        """X (4, 4) of the attributes `pos` and one of quat, axisangle, euler, xyaxes, zaxis."""
        return pose(self.rotation(a), np.array(numbers(a, "pos", 3, (0.0, 0.0, 0.0), self.file)))

    def rotation(self, a: Attributes) -> FloatArray:
        """R (3, 3); the identity where no attribute gives one."""
        unit = np.pi / 180.0 if self.degrees else 1.0
        if "axisangle" in a:
            *axis, angle = numbers(a, "axisangle", 4, None, self.file)
            return Rotation.from_rotvec(self._unit(axis, "axisangle") * angle * unit).as_matrix()
        if "euler" in a:
            R = np.eye(3)
            for axis, angle in zip(self.sequence, numbers(a, "euler", 3, None, self.file), strict=True):
                turn = Rotation.from_euler(axis.lower(), angle * unit).as_matrix()
                R = R @ turn if axis.islower() else turn @ R  # Lower case turns with the frame, upper case does not.
            return R
        if "xyaxes" in a:
            values = np.array(numbers(a, "xyaxes", 6, None, self.file))
            x = self._unit(values[:3], "xyaxes")
            y = self._unit(values[3:] - (values[3:] @ x) * x, "xyaxes")
            return np.stack([x, y, np.cross(x, y)], axis=1)
        if "zaxis" in a:
            return self.z_along(np.array(numbers(a, "zaxis", 3, None, self.file)))
        quat = np.array(numbers(a, "quat", 4, (1.0, 0.0, 0.0, 0.0), self.file))
        self._unit(quat, "quat")
        return matrix_of(quat)

    def z_along(self, direction: FloatArray) -> FloatArray:
        """The rotation (3, 3) of least angle that takes z to `direction`."""
        return shortest_rotation(np.array([0.0, 0.0, 1.0]), self._unit(direction, "zaxis"))

    def _unit(self, vector: FloatArray | list[float], name: str) -> FloatArray:
        length = float(np.linalg.norm(vector))
        if not length > 1e-12:
            raise invalid_recording("replay/invalid-value", f"{name} has no direction", self.file)
        return np.asarray(vector) / length
