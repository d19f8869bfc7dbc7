"""`oriented`: an axis of an object points in a direction of the world or toward another object."""

from __future__ import annotations

from typing import ClassVar, Self

import numpy as np
from pydantic import Field, model_validator
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, angle_between, length
from task.predicates.protocol import Instant, Object, Radians


class Oriented(Instant):
    """The angle between an axis of the object (its front by default) and `direction`, or the way to `toward`.

    With `either_way` the opposite direction does too, as for a book that may lie either way round.
    """

    func: ClassVar[str] = "oriented"
    object: Object
    axis: tuple[float, float, float] | None = Field(
        default=None, description="in the object's frame; its front by default"
    )
    direction: tuple[float, float, float] | None = Field(default=None, description="in the world")
    toward: str | None = Field(default=None, description="an object toward which it points, in the ground plane")
    tolerance: Radians = Field(default=0.2618, description="most angle (rad); 15 degrees")
    either_way: bool = False

    @model_validator(mode="after")
    def _one_goal(self) -> Self:
        if (self.direction is None) == (self.toward is None):
            raise ValueError("give `direction` or `toward`, one of them")
        if self.direction is not None and not any(self.direction):
            raise ValueError("`direction` has no length")
        return self

    @override
    def holds(self, frames: Frames) -> BoolArray:
        axis = frames.direction(self.object, self.axis or frames.facts(self.object).front)
        if self.toward is not None:
            way = frames.centre(self.toward) - frames.centre(self.object)
            flat = np.array([1.0, 1.0, 0.0])
            axis, goal = axis * flat, way * flat
            defined = (length(goal) > 0.0) & (length(axis) > 0.0)
        else:
            assert self.direction is not None
            goal, defined = np.asarray(self.direction), np.ones(len(frames), dtype=bool)
        angle = angle_between(axis, goal)
        if self.either_way:
            angle = np.minimum(angle, np.pi - angle)
        return defined & (angle <= self.tolerance)
