"""The independent judge of finished scenes."""

from geom.scene_check.check import check
from geom.scene_check.model import (
    CheckKeepOut,
    CheckObject,
    CheckPlace,
    CheckPrism,
    CheckReach,
    CheckRelation,
    CheckScene,
    Violation,
    ViolationKind,
)

__all__ = [
    "CheckKeepOut",
    "CheckObject",
    "CheckPlace",
    "CheckPrism",
    "CheckReach",
    "CheckRelation",
    "CheckScene",
    "Violation",
    "ViolationKind",
    "check",
]
