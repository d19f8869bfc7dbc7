"""`covered`: an object is under an upturned cup."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.polygons import in_volume
from task.predicates.placement.placed import Placed
from task.predicates.protocol import Metres, Object, Radians


class Covered(Placed):
    """The cup's opening points down, and the centre of the object lies in its volume."""

    func: ClassVar[str] = "covered"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "contacts", "volumes"})
    object: Object
    cup: Object
    volume: str = Field(default="auto", description="an anchor of the record; the main volume by default")
    tilt: Radians = Field(default=0.2, description="most angle between the opening and straight down (rad)")
    below_rim_m: Metres = Field(default=0.01, description="how far the centre may be outside of the rim (m)")

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        volume, body = frames.volume(self.cup, self.volume)
        down = -frames.rotation(body)[:, 2, 2] >= np.cos(self.tilt)
        centre = frames.in_anchor(frames.centre(self.object)[:, None], volume, body)[:, 0]
        nudged = centre - np.array([0.0, 0.0, self.below_rim_m])
        return down & (in_volume(centre, volume) | in_volume(nudged, volume))

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return (self.cup,)
