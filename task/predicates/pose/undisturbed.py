"""`undisturbed`: objects are where they were when the episode began."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, angle_between, length
from task.predicates.protocol import Instant, Metres, Objects, Radians


class Undisturbed(Instant):
    """No object is farther from, or turned more against, its pose in the first frame.

    One that was moved and put back is where it was. `failure: {_func: negation, of: ...}` notices every disturbance.
    """

    func: ClassVar[str] = "undisturbed"
    things: Objects = Field(alias="objects")
    moved_m: Metres = Field(default=0.02, description="most distance of the origin from where it was (m)")
    turned: Radians = Field(default=0.2618, description="most angle of any axis to where it pointed (rad); 15 degrees")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        before, result = frames.at_reset(), np.ones(len(frames), dtype=bool)
        for body in (frames.facts(name).body for name in self.things):
            result &= length(frames.position(body) - before.position(body)) <= self.moved_m
            now, then = frames.rotation(body), before.rotation(body)[0]
            for axis in range(3):
                result &= angle_between(now[:, :, axis], then[:, axis]) <= self.turned
        return result
