"""The independent judge of finished scenes: plain arrays in, violations out. It imports no compiler and no solver.

`model.py` has the data; `check_scene.py` judges one scene, `check_batch.py` many; `from_plan.py` reads plan documents.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from scene_check.check_scene import check
    from scene_check.model import (
        CheckObject,
        CheckScene,
        PosedPlace,
        Violation,
        ViolationKind,
    )

__all__ = [
    "CheckObject",
    "CheckScene",
    "PosedPlace",
    "Violation",
    "ViolationKind",
    "check",
]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "CheckObject": "scene_check.model",
        "CheckScene": "scene_check.model",
        "PosedPlace": "scene_check.model",
        "Violation": "scene_check.model",
        "ViolationKind": "scene_check.model",
        "check": "scene_check.check_scene",
    },
)
