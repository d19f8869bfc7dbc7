"""Line segments (asset frame, metres) of the gripper of each grasp, for the preview of an object's grasps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geom.grasp.gripper import Gripper
from geom.pose import apply, pose_from_quat
from render.drawn_grasp import DrawnGrasp
from schemas.affordances import AffordanceEvidence, Grasp


def drawn_grasps(affordances: Sequence[AffordanceEvidence], gripper: Gripper = Gripper()) -> tuple[DrawnGrasp, ...]:
    """Fingers, crossbar and stem of the gripper of each grasp, closed on the object, asset frame."""
    grasps = [e.value for e in affordances if isinstance(e.value, Grasp)]
    return tuple(_drawn(grasp, gripper) for grasp in grasps)


def _drawn(grasp: Grasp, gripper: Gripper) -> DrawnGrasp:
    side, tip, root = 0.5 * grasp.width_m, 0.5 * gripper.pad_m[1], -gripper.palm_to_pad_m
    lines = np.array(
        [
            [[-side, 0, tip], [-side, 0, root]],
            [[side, 0, tip], [side, 0, root]],
            [[-side, 0, root], [side, 0, root]],
            [[0, 0, root], [0, 0, root - 0.3 * gripper.palm_to_pad_m]],
        ]
    )
    X_AG = pose_from_quat(np.array(grasp.quat_wxyz), grasp.position_m)
    return DrawnGrasp(apply(X_AG, lines.reshape(-1, 3)).reshape(-1, 2, 3), grasp.trial)
