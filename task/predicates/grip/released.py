"""`released`: no gripper touches the object."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, length
from task.predicates.grip.grip import bodies_of
from task.predicates.protocol import Instant, Metres, Object


class Released(Instant):
    """No finger or palm touches the object, and every palm is at least so far from its centre."""

    func: ClassVar[str] = "released"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "contacts"})
    object: Object
    retreat_m: Metres = Field(
        default=0.0, description="least distance of every palm's origin from the object's centre (m)"
    )

    @override
    def holds(self, frames: Frames) -> BoolArray:
        bodies, centre = bodies_of(frames, self.object), frames.centre(self.object)
        free = length(centre) >= 0.0
        for gripper in frames.log.grippers:
            for part in (gripper.palm, *gripper.fingers):
                free = free & ~frames.touches_any(part, bodies)
            if self.retreat_m > 0.0:
                free = free & (length(frames.position(gripper.palm) - centre) >= self.retreat_m)
        return free
