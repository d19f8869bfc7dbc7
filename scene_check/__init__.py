"""The independent judge of finished scenes: plain arrays in, violations out. It imports no compiler and no solver.

`model.py` has the data; `check_scene.py` judges one scene, `check_batch.py` many; `from_plan.py` reads plan documents.
"""

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
