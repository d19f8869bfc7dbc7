"""`joint_at`: a joint is in a range of positions: a drawer open, a door closed, a knob at a mark."""

from __future__ import annotations

from typing import ClassVar, Self

from pydantic import Field, model_validator
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.protocol import Instant


class JointAt(Instant):
    """`at_least` and `at_most` in the unit of the joint (rad or m)."""

    func: ClassVar[str] = "joint_at"
    needs: ClassVar[frozenset[str]] = frozenset({"joints"})
    joint: str = Field(description="`<object>/<joint>`")
    at_least: float | None = Field(default=None, description="rad or m")
    at_most: float | None = Field(default=None, description="rad or m")

    @model_validator(mode="after")
    def _a_range(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise ValueError("give `at_least`, `at_most` or both")
        if self.at_least is not None and self.at_most is not None and self.at_least > self.at_most:
            raise ValueError("`at_least` is above `at_most`")
        return self

    @override
    def holds(self, frames: Frames) -> BoolArray:
        q = frames.joint(self.joint)
        result = q == q
        if self.at_least is not None:
            result &= q >= self.at_least
        if self.at_most is not None:
            result &= q <= self.at_most
        return result
