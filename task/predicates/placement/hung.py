"""`hung`: an object hangs on another: it touches that alone, and its weight is below the hook."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.grip.grip import bodies_of
from task.predicates.placement.placed import Placed
from task.predicates.protocol import Metres, Object


class Hung(Placed):
    """The object touches the hook and nothing else, and the centre of its box is below the top of the hook."""

    func: ClassVar[str] = "hung"
    object: Object
    hook: Object
    below_m: Metres = Field(
        default=0.0, description="least depth of the centre below the highest point of the hook (m)"
    )

    @override
    def is_placed(self, frames: Frames) -> BoolArray:
        hook, thing = bodies_of(frames, self.hook), bodies_of(frames, self.object)
        touches = np.zeros(len(frames), dtype=bool)
        for body in thing:
            touches |= frames.touches_any(body, hook)
        for body in thing:
            touches &= ~frames.touches_any(body, but=hook | thing)
        top = frames.points(self.hook)[..., 2].max(axis=1)
        return touches & (frames.centre(self.object)[:, 2] <= top - self.below_m)

    @override
    def placed_objects(self) -> tuple[str, ...]:
        return (self.object,)
