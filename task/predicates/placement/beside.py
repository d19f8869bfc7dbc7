"""`beside`: an object stands on one side of another, in a frame that the task names."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray, FloatArray
from task.frames import Frames
from task.predicates.placement.placed import Placed
from task.predicates.protocol import Metres, Object

# In the frame of a viewer who looks along +y, as the scene language has it.
SIDES = {"right": (1.0, 0.0), "left": (-1.0, 0.0), "behind": (0.0, 1.0), "in_front": (0.0, -1.0)}


class Beside(Placed):
    """On that side the footprints are apart by `gap_m` at most and do not overlap; across it the centres differ little.

    `frame` is the world, or an object (its body's x and y axes), such as the base of a robot.
    """

    func: ClassVar[str] = "beside"
    object: Object
    reference: Object
    side: Literal["left", "right", "in_front", "behind"]
    frame: str = Field(default="world", description="world, or the name of an object whose axes count")
    gap_m: Metres = Field(default=0.15, description="most gap between the footprints along the side (m)")
    across_m: Metres = Field(default=0.1, description="most offset of the centres across the side (m)")

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        along, across = self._axes(frames)
        gap = _least(frames.points(self.object), along) - _most(frames.points(self.reference), along)
        offset = frames.centre(self.object) - frames.centre(self.reference)
        sideways = np.abs(offset[:, 0] * across[:, 0] + offset[:, 1] * across[:, 1])
        return (gap >= 0.0) & (gap <= self.gap_m) & (sideways <= self.across_m)

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return (self.object,)

    def _axes(self, frames: Frames) -> tuple[FloatArray, FloatArray]:
        """(n, 2) unit vectors along the side and across it, in the ground plane."""
        x, y = SIDES[self.side]
        if self.frame == "world":
            along = np.broadcast_to(np.array([x, y]), (len(frames), 2))
        else:
            turn = frames.rotation(frames.facts(self.frame).body)
            heading = np.arctan2(turn[:, 1, 0], turn[:, 0, 0])
            cos, sin = np.cos(heading), np.sin(heading)
            along = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)
        return along, np.stack([-along[:, 1], along[:, 0]], axis=1)


def _least(points: FloatArray, axis: FloatArray) -> FloatArray:
    return (points[..., 0] * axis[:, None, 0] + points[..., 1] * axis[:, None, 1]).min(axis=1)


def _most(points: FloatArray, axis: FloatArray) -> FloatArray:
    return (points[..., 0] * axis[:, None, 0] + points[..., 1] * axis[:, None, 1]).max(axis=1)
