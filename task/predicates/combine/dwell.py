"""`dwell`: a condition has held without a break for a time."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.protocol import Part, Predicate, Seconds


class Dwell(Predicate):
    """From the first frame in which it holds, counted anew after each break; only time after activation counts."""

    func: ClassVar[str] = "dwell"
    needs: ClassVar[frozenset[str]] = frozenset()
    of: Part
    for_s: Seconds = Field(description="how long it has to hold (s)")

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        since, before = carry or (None, self.of.start())
        inner, after = self.of.values(frames, before)
        t_s = frames.t_s
        starts = inner & ~np.concatenate([[since is not None], inner[:-1]])
        at = np.maximum.accumulate(np.where(starts, np.arange(1, len(inner) + 1), 0))
        begin = np.where(at > 0, t_s[np.maximum(at - 1, 0)], np.inf if since is None else since)
        result = inner & (t_s - begin >= self.for_s)
        if len(inner):
            since = float(begin[-1]) if inner[-1] else None
        return result, (since, after)
