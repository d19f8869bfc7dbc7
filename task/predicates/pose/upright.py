"""`upright`: an object stands as in its reference pose, whatever its heading."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, angle_between
from task.predicates.protocol import Instant, Object, Radians


class Upright(Instant):
    """The angle between the object's upright direction and the vertical."""

    func: ClassVar[str] = "upright"
    object: Object
    tilt: Radians = Field(default=0.2618, description="most angle to the vertical (rad); 15 degrees")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        up = frames.direction(self.object, frames.facts(self.object).up)
        return angle_between(up, np.array([0.0, 0.0, 1.0])) <= self.tilt
