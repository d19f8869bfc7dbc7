"""`matches_attribute`: an object has an attribute, such as a colour or a shape: for nodes that choose among objects."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames, StateMissing
from task.predicates.protocol import Instant, Object


class MatchesAttribute(Instant):
    """The same in every frame, because attributes do not change. Without the attribute it is an error, not false."""

    func: ClassVar[str] = "matches_attribute"
    needs: ClassVar[frozenset[str]] = frozenset({"attributes"})
    object: Object
    attribute: str
    equals: str | None = Field(default=None, description="its value")
    like: str | None = Field(default=None, description="an object that must have the same value")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        value = self._value(frames, self.object)
        goal = self.equals if self.like is None else self._value(frames, self.like)
        return np.full(len(frames), value == goal)

    def _value(self, frames: Frames, name: str) -> str:
        attributes = frames.facts(name).attributes
        if self.attribute not in attributes:
            raise StateMissing(
                f"`{name}` has no attribute `{self.attribute}`; it has {', '.join(attributes) or 'none'}", name
            )
        return attributes[self.attribute]
