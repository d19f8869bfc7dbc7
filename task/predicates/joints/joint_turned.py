"""`joint_turned`: a joint has been turned by so much since the node became active: a nut, a cap, a valve."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.protocol import Predicate

_TURN = 2.0 * np.pi


class JointTurned(Predicate):
    """Net turns: what is turned back counts against it. Positions that wrap at a full turn are unwrapped, on the
    assumption that less than half a turn passes from frame to frame.
    """

    func: ClassVar[str] = "joint_turned"
    needs: ClassVar[frozenset[str]] = frozenset({"joints"})
    joint: str = Field(description="`<object>/<joint>`, a revolute one")
    turns: float = Field(description="net turns, negative for clockwise about the axis")
    wraps: bool = Field(default=True, description="whether the log's positions may jump by a full turn")

    @override
    def values(self, frames: Frames, carry: Any) -> tuple[BoolArray, Any]:
        q = frames.joint(self.joint)
        if not len(q):
            return np.zeros(0, dtype=bool), carry
        before, turned = carry or (float(q[0]), 0.0)
        steps = np.diff(q, prepend=before)
        if self.wraps:
            steps = steps - _TURN * np.round(steps / _TURN)
        total = np.cumsum(np.concatenate([[turned], steps]))[1:]
        goal = _TURN * self.turns
        reached = total >= goal if self.turns >= 0.0 else total <= goal
        return reached, (float(q[-1]), float(total[-1]))
