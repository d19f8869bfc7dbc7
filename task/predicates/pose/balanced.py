"""`balanced`: a scale's beam, or any body on a pivot, is level and stays so."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pydantic import Field
from typing_extensions import override

from schemas.arrays import BoolArray
from task.frames import Frames
from task.predicates.protocol import Instant, Radians


class Balanced(Instant):
    """A joint of the scale is within `tolerance` of level. Put it into `dwell`: a swinging beam passes level too."""

    func: ClassVar[str] = "balanced"
    needs: ClassVar[frozenset[str]] = frozenset({"joints"})
    joint: str = Field(description="`<object>/<joint>` of the beam")
    level: float = Field(default=0.0, description="position of the joint where the beam is level (rad)")
    tolerance: Radians = Field(default=0.0349, description="most angle (rad); 2 degrees")

    @override
    def holds(self, frames: Frames) -> BoolArray:
        return np.abs(frames.joint(self.joint) - self.level) <= self.tolerance
