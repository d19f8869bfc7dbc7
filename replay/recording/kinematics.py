"""Forward kinematics of an episode's robots: link poses X_WL from joint positions (rad, m) and base poses."""

from __future__ import annotations

import numpy as np

from replay.recording.episode import Link, Robot
from schemas.arrays import FloatArray


def link_poses(robot: Robot, q: FloatArray, X_WR: FloatArray) -> FloatArray:
    """X_WL (k, links, 4, 4) of all links at k states: q (k, j), base poses X_WR (k, 4, 4)."""
    poses = np.empty((len(q), len(robot.links), 4, 4))
    for number, link in enumerate(robot.links):
        parent = X_WR if link.parent < 0 else poses[:, link.parent]
        poses[:, number] = parent @ link.X_PL @ joint_motion(link, position(link, q))
    return poses


def moving_links(robot: Robot) -> frozenset[int]:
    """Numbers of the links that may have moved: pose not the same in every row, or a rate recorded."""
    if np.ptp(robot.X_WR, axis=0).any():
        return frozenset(range(len(robot.links)))
    changes = np.ptp(robot.q, axis=0) != 0.0
    if robot.qd is not None:
        changes |= np.abs(robot.qd).max(axis=0) != 0.0
    moving: set[int] = set()
    for number, link in enumerate(robot.links):
        if link.parent in moving or (link.coordinate >= 0 and changes[link.coordinate]):
            moving.add(number)
    return frozenset(moving)


def position(link: Link, q: FloatArray) -> FloatArray:
    """(k,) position of the link's joint; zeros for a fixed one."""
    return link.gain * q[:, link.coordinate] + link.offset if link.coordinate >= 0 else np.zeros(len(q))


def joint_motion(link: Link, position: FloatArray) -> FloatArray:
    """(k, 4, 4) motion of a joint from its zero (Rodrigues' formula)."""
    X = np.tile(np.eye(4), (len(position), 1, 1))
    if link.kind == "prismatic":
        X[:, :3, 3] = position[:, None] * link.axis_L
    elif link.kind == "revolute":
        x, y, z = link.axis_L
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        X[:, :3, :3] += np.sin(position)[:, None, None] * K + (1.0 - np.cos(position))[:, None, None] * (K @ K)
    return X
