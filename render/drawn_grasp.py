"""The renderer's input for one grasp; in a module of its own, so that importing it does not load VTK."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from schemas.affordances import Trial
from schemas.arrays import FloatArray


@dataclass(frozen=True)
class DrawnGrasp:
    """Lines (k, 2, 3) of a gripper in the asset frame, metres, and the result of its trial."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    lines_m: FloatArray
    trial: Trial
