"""The independent judge of finished scenes."""

from scene_check.check_scene import check
from scene_check.model import (
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
