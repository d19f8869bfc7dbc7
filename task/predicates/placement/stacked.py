"""`stacked`: each object stands on the one before it, in line over each other."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, length
from task.predicates.placement.on import On
from task.predicates.placement.placed import Placed
from task.predicates.protocol import Metres, Objects


class Stacked(Placed):
    """A tower from the bottom up: each layer is `on` the one below, its centre within `offset_m` of that one's."""

    func: ClassVar[str] = "stacked"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "contacts", "surfaces"})
    layers: Objects = Field(min_length=2, description="from the lowest to the highest")
    offset_m: Metres = Field(default=0.02, description="most offset of the centres of neighbours in the plane (m)")
    gap_m: Metres = Field(default=0.01, description="most gap between layers (m)")

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        result = frames.t_s == frames.t_s
        for below, above in zip(self.layers[:-1], self.layers[1:], strict=True):
            offset = frames.centre(above)[:, :2] - frames.centre(below)[:, :2]
            result &= length(offset) <= self.offset_m
            if result.any():
                result &= On(object=above, support=below, gap_m=self.gap_m, while_held=True).is_placed(frames)
        return result

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return self.layers
