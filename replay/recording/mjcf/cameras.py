"""Camera poses X_WC of a MuJoCo model's fixed cameras along a recording."""

from __future__ import annotations

import numpy as np

from replay.recording.episode import Camera
from replay.recording.kinematics import link_poses
from replay.recording.mjcf.episode_parts import Parts
from replay.recording.mjcf.read import MjModel
from schemas.arrays import FloatArray


def model_cameras(model: MjModel, parts: Parts, n: int, size_px: tuple[int, int]) -> tuple[Camera, ...]:
    """Every fixed camera of the model at n samples; `size_px` is width and height of the pictures."""
    poses: dict[str, FloatArray] = {}
    for robot in parts[0]:
        X_WL = link_poses(robot, robot.q, robot.X_WR)
        poses |= {link.name: X_WL[:, index] for index, link in enumerate(robot.links)}
    poses |= {body.name: body.X_WB for body in parts[1]}
    cameras = []
    for body in model.bodies:
        X_WB, at = np.eye(4), body
        while at.name not in poses and at.parent >= 0:
            X_WB, at = at.X_PB @ X_WB, model.bodies[at.parent]
        X_WB = poses.get(at.name, np.eye(4)) @ X_WB
        X_WB = np.broadcast_to(X_WB, (n, 4, 4))
        cameras += [Camera(c.name, X_WB @ c.X_BC, c.fovy_rad, *size_px) for c in body.cameras]
    return tuple(cameras)
