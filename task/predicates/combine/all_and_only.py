"""`all_and_only`: a condition holds for all of some objects and for none of the others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.combine.counted import MEMBER, for_members
from task.predicates.combine.logic import each
from task.predicates.protocol import Objects, Part, Predicate


class AllAndOnly(Predicate):
    """`where` holds for every one of `members` and for no one of `others`: `$member` in it stands for each."""

    func: ClassVar[str] = "all_and_only"
    needs: ClassVar[frozenset[str]] = frozenset()
    members: Objects
    others: Objects
    where: Part

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        outside = tuple(name for name in self.others if name not in self.members)
        results, after = each(for_members(self.where, (*self.members, *outside)), frames, carry)
        count = len(self.members)
        inside = np.logical_and.reduce(results[:count])
        return (inside & ~np.logical_or.reduce(results[count:])) if outside else inside, after

    @override
    def objects(self) -> Iterator[str]:
        return (name for name in super().objects() if name != MEMBER)
