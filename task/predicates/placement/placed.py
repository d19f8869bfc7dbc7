"""What all placements share: a thing that a gripper holds is not placed, unless the task allows it."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.grip.grip import is_held
from task.predicates.protocol import Instant

LEAST_TIP_COSINE = 0.5  # what is tipped by more than 60 degrees holds and carries nothing


class Placed(Instant):
    """A placement; while a gripper holds the object it does not count, so that no node completes before the release."""

    needs: ClassVar[frozenset[str]] = frozenset({"poses", "contacts"})
    while_held: bool = Field(default=False, description="whether it also counts while a gripper holds the object")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        placed = self.is_placed(frames)
        if self.while_held or not placed.any():
            return placed
        for name in self.placed_objects():
            placed = placed & ~is_held(frames, name)
        return placed

    @abstractmethod
    def is_placed(self, frames: Frames) -> BoolArray:
        """(n,) whether the object is there, held or not."""

    @abstractmethod
    def placed_objects(self) -> tuple[str, ...]:
        """The objects that no gripper may hold."""
