"""`aligned`: centres of objects lie on one line of the ground plane."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.placement.placed import Placed
from task.predicates.protocol import Metres, Objects


class Aligned(Placed):
    """All centres are within `tolerance_m` of a line along x or y of the world, in order along it where `ordered`."""

    func: ClassVar[str] = "aligned"
    objects_in_line: Objects = Field(alias="objects", min_length=2)
    axis: Literal["x", "y"] = "x"
    tolerance_m: Metres = Field(default=0.02, description="most distance of a centre from the line (m)")
    ordered: bool = Field(default=False, description="whether they follow each other along the axis as written")

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        along = 0 if self.axis == "x" else 1
        centres = np.stack([frames.centre(name) for name in self.objects_in_line], axis=1)
        off = centres[..., 1 - along]
        result = off.max(axis=1) - off.min(axis=1) <= 2.0 * self.tolerance_m
        if self.ordered:
            result &= (np.diff(centres[..., along], axis=1) > 0.0).all(axis=1)
        return result

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return self.objects_in_line
