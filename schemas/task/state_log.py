"""The state log: what a simulator or a recording says of a scene at every frame. Predicates of tasks read nothing else.

Frames: W world, z up; B body. Metres, radians, seconds, quaternions wxyz. Every array over frames has the rows of
`StateLog.t_s`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from pydantic import ConfigDict

from schemas.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class GripperParts:
    """A gripper of a log: `palm` is the body that moves with it, `fingers` the bodies that close on a thing."""

    name: str
    palm: str
    fingers: tuple[str, ...]


@dataclass(frozen=True)
class StateLog:
    """The motion of all bodies and joints over n frames.

    t_s            (n,) stamps, increasing.
    bodies         names of b bodies: links of robots, parts of mechanisms, free objects, fixtures. An object of one
                   body has its own name, a link `<object>/<link>`.
    position_m     (n, b, 3) origins in W; quat_wxyz (n, b, 4) unit quaternions, W from B.
    joints         names of j joints, `<object>/<joint>`; joint_position (n, j) in rad or m.
    contact_pairs  p pairs of bodies for which contact was observed; touching (n, p). `touching` None: not observed.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    t_s: FloatArray
    bodies: tuple[str, ...]
    position_m: FloatArray
    quat_wxyz: FloatArray
    joints: tuple[str, ...] = ()
    joint_position: FloatArray | None = None
    contact_pairs: tuple[tuple[str, str], ...] = ()
    touching: BoolArray | None = None
    grippers: tuple[GripperParts, ...] = ()

    def __len__(self) -> int:
        return len(self.t_s)

    @cached_property
    def body_index(self) -> dict[str, int]:
        """Column of each body by its name."""
        return {name: column for column, name in enumerate(self.bodies)}

    @cached_property
    def joint_index(self) -> dict[str, int]:
        """Column of each joint by its name."""
        return {name: column for column, name in enumerate(self.joints)}

    @cached_property
    def contacts_of(self) -> dict[str, dict[str, int]]:
        """For each body the bodies it may touch, with the column of `touching`."""
        result: dict[str, dict[str, int]] = {}
        for column, (one, other) in enumerate(self.contact_pairs):
            result.setdefault(one, {})[other] = column
            result.setdefault(other, {})[one] = column
        return result

    def rows(self, first: int, last: int) -> StateLog:
        """Frames [first, last) as a log."""
        return replace(
            self,
            t_s=self.t_s[first:last],
            position_m=self.position_m[first:last],
            quat_wxyz=self.quat_wxyz[first:last],
            joint_position=None if self.joint_position is None else self.joint_position[first:last],
            touching=None if self.touching is None else self.touching[first:last],
        )

    def faults(self) -> list[str]:
        """What is wrong with its shapes and values, a line each; empty for a sound log."""
        n, b = len(self.t_s), len(self.bodies)
        arrays: dict[str, tuple[FloatArray | BoolArray, tuple[int, ...]]] = {
            "position_m": (self.position_m, (n, b, 3)),
            "quat_wxyz": (self.quat_wxyz, (n, b, 4)),
        }
        if self.touching is not None:
            arrays["touching"] = (self.touching, (n, len(self.contact_pairs)))
        if self.joint_position is not None:
            arrays["joint_position"] = (self.joint_position, (n, len(self.joints)))
        lines = [
            f"{name} has the shape {array.shape}, not {expected}"
            for name, (array, expected) in arrays.items()
            if array.shape != expected
        ]
        if self.joints and self.joint_position is None:
            lines.append("it names joints and has no joint_position")
        if n == 0:
            lines.append("it has no frame")
        if lines:
            return lines
        if not np.all(np.isfinite(self.t_s)) or np.any(np.diff(self.t_s) <= 0.0):
            lines.append("stamps do not increase")
        for name, values in (("position_m", self.position_m), ("joint_position", self.joint_position)):
            if values is not None and not np.isfinite(values).all():
                lines.append(f"{name} is not finite in frame {int(np.argwhere(~np.isfinite(values))[0][0])}")
        odd = ~(np.abs(np.linalg.norm(self.quat_wxyz, axis=-1) - 1.0) < _UNIT_ERROR).all(axis=1)
        if odd.any():
            lines.append(f"quat_wxyz is no unit quaternion in frame {int(np.argmax(odd))}")
        repeated = sorted({name for name in self.bodies if self.bodies.count(name) > 1})
        return lines + [f"the body {name} occurs twice" for name in repeated]


_UNIT_ERROR = 1e-3  # what single precision and rounding to a few digits leave
