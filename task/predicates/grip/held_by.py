"""`held_by`: a gripper has lifted the object: between its fingers, and nothing else carries it."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.grip.grip import bodies_of, fingers_on, gripper_bodies
from task.predicates.protocol import Instant, Object


class HeldBy(Instant):
    """At least two fingers touch the object; off its support, nothing but grippers touches it."""

    func: ClassVar[str] = "held_by"
    needs: ClassVar[frozenset[str]] = frozenset({"contacts", "grippers"})
    object: Object
    gripper: str | None = Field(default=None, description="a gripper of the log; any by default")
    off_support: bool = Field(default=True, description="whether the object must have left what it stood on")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        grasped = fingers_on(frames, self.object, self.gripper)
        if not self.off_support:
            return grasped
        others = gripper_bodies(frames) | bodies_of(frames, self.object)
        for body in bodies_of(frames, self.object):
            grasped = grasped & ~frames.touches_any(body, but=others)
        return grasped
