"""`base_near`: the base of a mobile robot stands near an object and faces it."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, length
from task.predicates.protocol import Instant, Metres, Object, Radians


class BaseNear(Instant):
    """Distance in the ground plane from the base's origin to the object's centre, and the angle of its x axis to it."""

    func: ClassVar[str] = "base_near"
    base: Object
    object: Object
    distance_m: Metres = Field(default=1.0, description="most distance (m)")
    facing: Radians = Field(
        default=3.1415926535897936, description="most angle between the base's x axis and the way (rad)"
    )

    @override
    def holds(self, frames: Frames) -> BoolArray:
        base = frames.facts(self.base).body
        way = (frames.centre(self.object) - frames.position(base))[:, :2]
        x_axis = frames.rotation(base)[:, :2, 0]
        across = x_axis[:, 0] * way[:, 1] - x_axis[:, 1] * way[:, 0]
        along = x_axis[:, 0] * way[:, 0] + x_axis[:, 1] * way[:, 1]
        return (length(way) <= self.distance_m) & (np.abs(np.arctan2(across, along)) <= self.facing)
