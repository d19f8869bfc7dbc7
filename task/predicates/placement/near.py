"""`near`: the centres of two objects are within a distance."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import AliasChoices, Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, length
from task.predicates.placement.placed import Placed
from task.predicates.protocol import Metres, Object


class Near(Placed):
    """Distance of the centres, in space or in the plane.

    `object_near_destination` with `object_cfg` and `destination_cfg`, as the paper lists it, is the same.
    """

    func: ClassVar[str] = "near"
    object: Object = Field(validation_alias=AliasChoices("object", "object_cfg"))
    destination: Object = Field(validation_alias=AliasChoices("destination", "destination_cfg"))
    distance_m: Metres = Field(default=0.1, description="most distance between the centres (m)")
    measure: Literal["space", "plane"] = Field(default="plane", description="with or without the difference in height")

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        offset = frames.centre(self.object) - frames.centre(self.destination)
        return length(offset if self.measure == "space" else offset[:, :2]) <= self.distance_m

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return (self.object,)
