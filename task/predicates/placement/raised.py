"""`raised`: an object is at least so high over a surface."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.protocol import Instant, Metres, Object


class Raised(Instant):
    """Height of the lowest point of the object over the surface, along the surface's normal. Together with `held_by`:
    a gripper lifted it.
    """

    func: ClassVar[str] = "raised"
    needs: ClassVar[frozenset[str]] = frozenset({"poses", "surfaces"})
    object: Object
    over: Object
    surface: str = Field(default="auto", description="an anchor of the record; the main surface by default")
    height_m: Metres = Field(description="least height of the lowest point (m)")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        surface, body = frames.surface(self.over, self.surface)
        return frames.in_anchor(frames.points(self.object), surface, body)[..., 2].min(axis=1) >= self.height_m
