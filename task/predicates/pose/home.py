"""`home`: a robot is back in its home position."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, StateMissing
from task.predicates.protocol import Instant, Metres, Radians


class Home(Instant):
    """Every joint of the scene's home position, or of one robot, is within the tolerance of it."""

    func: ClassVar[str] = "home"
    needs: ClassVar[frozenset[str]] = frozenset({"joints", "home"})
    robot: str | None = Field(
        default=None, description="joints whose names begin with this and a slash; all by default"
    )
    tolerance: Radians = Field(default=0.1, description="most difference of a joint (rad)")
    tolerance_m: Metres = Field(default=0.01, description="most difference of a joint named in `sliding` (m)")
    sliding: tuple[str, ...] = Field(default=(), description="joints that slide")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        start = "" if self.robot is None else f"{self.robot}/"
        joints = {name: q for name, q in frames.scene.home.items() if name.startswith(start)}
        if not joints:
            raise StateMissing(f"there is no home position{f' of {self.robot}' if self.robot else ''}")
        result = np.ones(len(frames), dtype=bool)
        for name, position in joints.items():
            bound = self.tolerance_m if name in self.sliding else self.tolerance
            result &= np.abs(frames.joint(name) - position) <= bound
        return result
