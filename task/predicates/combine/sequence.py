"""`sequence`: conditions become true one after the other, in this order and no other."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.combine.logic import each
from task.predicates.protocol import Part, Predicate


class Progress(NamedTuple):
    """How many steps are done, whether a wrong one spoiled it for good, and the values of the last row."""

    done: int
    spoiled: bool
    last: tuple[bool, ...]
    carried: Any


class Sequence(Predicate):
    """A condition counts in the frame in which it becomes true; one that is true at the start has to end first.

    Another condition of the list that becomes true out of turn starts the sequence anew, or spoils it for good
    (`on_mistake: spoil`). Two in one frame are a mistake, because neither came first. The same condition may stand in
    the list several times.
    """

    func: ClassVar[str] = "sequence"
    needs: ClassVar[frozenset[str]] = frozenset()
    steps: tuple[Part, ...] = Field(min_length=2)
    on_mistake: Literal["restart", "spoil"] = "restart"

    @override
    def values(self, frames: Frames, carry: Progress | None) -> tuple[BoolArray, Any]:
        distinct = tuple(dict.fromkeys(self.steps))
        results, carried = each(distinct, frames, carry.carried if carry else None)
        rows = np.stack(results, axis=1)
        if not len(rows):
            return np.zeros(0, dtype=bool), carry
        last = np.array(carry.last) if carry else rows[0]
        rising = rows & ~np.concatenate([last[None], rows[:-1]])
        done, spoiled = (carry.done, carry.spoiled) if carry else (0, False)
        reached = np.zeros(len(rows), dtype=bool)
        order = [distinct.index(step) for step in self.steps]
        begin = 0
        for row in np.flatnonzero(rising.any(axis=1)).tolist():
            reached[begin:row] = done == len(order)
            begin = row
            events = np.flatnonzero(rising[row]).tolist()
            done, spoiled = self._after(events, order, done, spoiled)
        reached[begin:] = done == len(order)
        return reached, Progress(done, spoiled, tuple(rows[-1].tolist()), carried)

    def _after(self, events: list[int], order: list[int], done: int, spoiled: bool) -> tuple[int, bool]:
        if spoiled:
            return 0, True
        if done < len(order) and events == [order[done]]:
            return done + 1, False
        if self.on_mistake == "spoil":
            return 0, True
        return (1 if events == [order[0]] else 0), False
