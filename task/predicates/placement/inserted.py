"""`inserted`: an object reaches into a hole by a depth: a peg, a plug, a ring over a rod."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.polygons import in_polygon
from task.predicates.placement.placed import Placed
from task.predicates.protocol import Metres, Object


class Inserted(Placed):
    """All of the object that is deeper than the rim lies within the opening, and its tip reaches `depth_m` below it."""

    func: ClassVar[str] = "inserted"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "contacts", "volumes"})
    object: Object
    hole: Object
    volume: str = Field(default="auto", description="an anchor of the record; the main volume by default")
    depth_m: Metres = Field(description="least depth of the tip below the rim, along the axis of the hole (m)")
    clearance_m: Metres = Field(default=0.002, description="how far corners may be outside of the measured opening (m)")

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        volume, body = frames.volume(self.hole, self.volume)
        corners = frames.in_anchor(frames.points(self.object), volume, body)
        below = corners[..., 2] < volume.height_m
        outline = np.array(volume.opening.outline_m)
        middle = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
        half = (outline.max(axis=0) - outline.min(axis=0)) / 2.0
        shrink = half / (half + self.clearance_m)
        x, y = (middle[k] + (corners[..., k] - middle[k]) * shrink[k] for k in (0, 1))
        within = in_polygon(x, y, volume.opening)
        deep = volume.height_m - corners[..., 2].min(axis=1) >= self.depth_m
        return deep & (within | ~below).all(axis=1)

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return (self.object,)
