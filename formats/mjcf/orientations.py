"""How an MJCF model writes rotations: angles in degrees or radians, the order of Euler angles, five spellings.

mujoco.readthedocs.io/en/stable/modeling.html#frame-orientations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from formats.attributes import Attributes, numbers, vector
from formats.mjcf.defaults import ORIENTATIONS
from formats.xml_elements import refuse
from geom.pose import matrix_of, pose, rotation_about, shortest_rotation
from schemas.arrays import FloatArray
from schemas.robot_description import SourceLine

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Orientations:
    """`degrees`: angles are in degrees. `sequence`: three letters, lower case turns with the frame, upper case not."""

    degrees: bool = True
    sequence: str = "xyz"

    @property
    def rad_per_unit(self) -> float:
        """Radians of one unit of the model's angles."""
        return float(np.pi / 180.0) if self.degrees else 1.0

    def pose(self, a: Attributes, source: SourceLine) -> FloatArray:
        """X (4, 4) of the attributes `pos` and one of quat, axisangle, euler, xyaxes, zaxis."""
        return pose(self.rotation(a, source), np.array(vector(a, "pos", (0.0, 0.0, 0.0), source)))

    def rotation(self, a: Attributes, source: SourceLine) -> FloatArray:
        """R (3, 3); the identity where no attribute gives one. Raises InvalidInput `robot/invalid-orientation`."""
        given = [key for key in ORIENTATIONS if key in a]
        if len(given) > 1:
            refuse("robot/invalid-orientation", f"both {' and '.join(given)} are given", source, " ".join(given))
        if "axisangle" in a:
            *axis, angle = numbers(a, "axisangle", 4, None, source)
            return rotation_about(unit(axis, "axisangle", source), angle * self.rad_per_unit)
        if "euler" in a:
            turned: FloatArray = np.eye(3)
            for letter, angle in zip(self.sequence, vector(a, "euler", None, source), strict=True):
                turn = rotation_about(_AXES[letter.lower()], angle * self.rad_per_unit)
                turned = turned @ turn if letter.islower() else turn @ turned
            return turned
        if "xyaxes" in a:
            values = np.array(numbers(a, "xyaxes", 6, None, source))
            x = unit(values[:3], "xyaxes", source)
            y = unit(values[3:] - (values[3:] @ x) * x, "xyaxes", source)
            return np.stack([x, y, np.cross(x, y)], axis=1)
        if "zaxis" in a:
            return z_along(np.array(vector(a, "zaxis", None, source)), source)
        quat = np.array(numbers(a, "quat", 4, (1.0, 0.0, 0.0, 0.0), source))
        unit(quat, "quat", source)
        return matrix_of(quat)


def z_along(direction: FloatArray, source: SourceLine) -> FloatArray:
    """The rotation (3, 3) of least angle that takes z to `direction`."""
    return shortest_rotation(np.array([0.0, 0.0, 1.0]), unit(direction, "the direction", source))


def unit(vector: FloatArray | list[float], name: str, source: SourceLine) -> FloatArray:
    """The vector over its length. Raises InvalidInput `robot/invalid-orientation` where that is zero."""
    length = float(np.linalg.norm(vector))
    if not length > 1e-12:
        refuse("robot/invalid-orientation", f"{name} has no direction", source, value=0.0)
    return np.asarray(vector, dtype=np.float64) / length
