"""Camera poses X_WC of a MuJoCo model's fixed cameras along a recording."""

from __future__ import annotations

import numpy as np

from replay.recording.episode import Camera
from replay.recording.kinematics import link_poses
from replay.recording.mjcf.bodies import RecordedBodies
from replay.recording.mjcf.episode_parts import Parts
from schemas.arrays import FloatArray


def model_cameras(model: RecordedBodies, parts: Parts, n: int, size_px: tuple[int, int]) -> tuple[Camera, ...]:
    """Every fixed camera of the model at n samples; `size_px` is width and height of the pictures."""
    poses: dict[str, FloatArray] = {}
    for robot in parts[0]:
        X_WL = link_poses(robot, robot.q, robot.X_WR)
        poses |= {link.name: X_WL[:, index] for index, link in enumerate(robot.links)}
    poses |= {body.name: body.X_WB for body in parts[1]}
    cameras = []
    for number, body in enumerate(model.links):
        X_WB, at = np.eye(4), number
        while model.links[at].name not in poses and model.parent[at] >= 0:
            X_WB, at = model.X_PB[at] @ X_WB, model.parent[at]
        X_WB = poses.get(model.links[at].name, np.eye(4)) @ X_WB
        X_WB = np.broadcast_to(X_WB, (n, 4, 4))
        # A camera that follows something is no recorded camera.
        cameras += [Camera(c.name, X_WB @ c.X_LC, c.fovy_rad, *size_px) for c in body.cameras if c.fixed]
    return tuple(cameras)
