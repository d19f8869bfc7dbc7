"""`pressed`: a button has been pressed exactly so many times since the node became active."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator
from typing_extensions import override

from schemas.arrays import BoolArray, FloatArray, IntArray
from task.frames import Frames
from task.predicates.protocol import Predicate


class Presses(NamedTuple):
    """Whether the button was down in the last row, presses so far, and the stamp of the last one (s)."""

    down: bool
    presses: int
    last_s: float


class Pressed(Predicate):
    """A press counts when the joint reaches `press_at`; the next one only after it came back to `release_at`.

    Chatter around one threshold is then one press. A button that is down when the node becomes active has to come up
    first. With `settle_s` the count must have stood for so long, so that one press too many is seen.
    """

    func: ClassVar[str] = "pressed"
    needs: ClassVar[frozenset[str]] = frozenset({"joints"})
    joint: str = Field(description="`<object>/<joint>` of the button")
    press_at: float = Field(description="position at which it is pressed (rad or m)")
    release_at: float = Field(description="position at which it is up again (rad or m)")
    times: int = Field(default=1, ge=1)
    settle_s: float = Field(default=0.0, ge=0.0, description="how long after the last press no other may come (s)")

    @model_validator(mode="after")
    def _hysteresis(self) -> Self:
        if self.press_at == self.release_at:
            raise ValueError("`release_at` must differ from `press_at`")
        return self

    @override
    def values(self, frames: Frames, carry: Presses | None) -> tuple[BoolArray, Any]:
        q, t_s = frames.joint(self.joint), frames.t_s
        if not len(q):
            return np.zeros(0, dtype=bool), carry
        reached, freed = self._bounds(q)
        before = carry or Presses(bool(~freed[0]), 0, -np.inf)
        counts, stamps, down = press_counts(reached, freed, t_s, before)
        result = (counts == self.times) & (t_s - stamps >= self.settle_s)
        return result, Presses(down, int(counts[-1]), float(stamps[-1]))

    def _bounds(self, q: FloatArray) -> tuple[BoolArray, BoolArray]:
        """(n,) whether it is down at least as far as a press, and whether it is up again."""
        if self.press_at > self.release_at:
            return q >= self.press_at, q <= self.release_at
        return q <= self.press_at, q >= self.release_at


def press_counts(
    reached: BoolArray, freed: BoolArray, t_s: FloatArray, before: Presses
) -> tuple[IntArray, FloatArray, bool]:
    """(n,) presses so far, (n,) stamp of the last one, and whether the button is down in the end."""
    marks = np.where(reached, 1, np.where(freed, -1, 0))
    known = np.where(marks != 0, np.arange(1, len(marks) + 1), 0)
    last = np.maximum.accumulate(known)
    down = np.where(last > 0, marks[np.maximum(last - 1, 0)] > 0, before.down)
    pressed = down & ~np.concatenate([[before.down], down[:-1]])
    counts = before.presses + np.cumsum(pressed)
    at = np.maximum.accumulate(np.where(pressed, np.arange(1, len(marks) + 1), 0))
    stamps = np.where(at > 0, t_s[np.maximum(at - 1, 0)], before.last_s)
    return counts, stamps, bool(down[-1])
