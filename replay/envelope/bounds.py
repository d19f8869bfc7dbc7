"""Proven bound (m) on the distance of link points from the chord between two states of a trajectory.

Along a joint-linear motion by dq a point's position p has d2p/ds2 = sum_ij dq_i dq_j d2p/dq_i dq_j. For joint i nearer
to the base than j the last factor is at most the point's distance from the axis of j (1 if j slides and i turns, 0 if
i slides). A curve deviates from its chord by at most an eighth of its largest second derivative. Distances from axes
are bounded over the interval: twice the distance is at most those at both ends and the way that the point makes
between, relative to the axis. A base that turns counts as one more joint, nearest to the root; its translation is
linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from replay.envelope.trajectory import Trajectory
from replay.recording.episode import Robot
from replay.recording.kinematics import link_poses
from schemas.arrays import FloatArray


@dataclass(frozen=True)
class Paths:
    """Points of a link along a trajectory: points_W (k, m, 3).

    error_bound_m  (k, m-1) bound on the distance of a point from the chord between two states: `chord_error_m`, which
                   falls as intervals are divided, plus `joint_deviation_m`, from the deviation of joints.
    """

    points_W: FloatArray
    chord_error_m: FloatArray
    joint_deviation_m: FloatArray

    @property
    def error_bound_m(self) -> FloatArray:
        """(k, m-1) the sum of both bounds."""
        return self.chord_error_m + self.joint_deviation_m


def paths(robot: Robot, trajectory: Trajectory, centres: list[FloatArray]) -> list[Paths]:
    """Paths of points centres[l] (k, 3) of every link l along a trajectory."""
    poses = link_poses(robot, trajectory.q, trajectory.X_WR)
    turned = np.abs(turns(trajectory.X_WR))
    moved = np.abs(np.diff(trajectory.q, axis=0))
    return [
        _link_paths(robot, number, trajectory, poses, moved, turned, points) for number, points in enumerate(centres)
    ]


def _link_paths(
    robot: Robot,
    number: int,
    trajectory: Trajectory,
    poses: FloatArray,
    moved: FloatArray,
    turned: FloatArray,
    points_L: FloatArray,
) -> Paths:
    X = poses[:, number]
    points_W = np.einsum("mij,kj->kmi", X[:, :3, :3], points_L) + X[:, :3, 3]
    steps = len(poses) - 1
    path_length = np.zeros(
        (len(points_L), steps)
    )  # of the point relative to the joint in hand, from the link to the root
    curve, deviation = np.zeros_like(path_length), np.zeros_like(path_length)
    chain = _chain(robot, number)
    amounts = [abs(robot.links[j].gain) * moved[:, robot.links[j].coordinate] for j in chain]
    turning = [a if robot.links[j].kind == "revolute" else np.zeros(steps) for j, a in zip(chain, amounts, strict=True)]
    for place, j in enumerate(chain):
        link = robot.links[j]
        deviates = abs(link.gain) * trajectory.deviation[:, link.coordinate]
        root_turns = sum(turning[place + 1 :], turned)  # joints nearer to the root that turn
        if link.kind == "prismatic":
            curve += amounts[place] * 2.0 * root_turns / 8.0
            deviation += deviates
            path_length += amounts[place] + 2.0 * deviates
        else:
            axis_W = poses[:, j, :3, :3] @ link.axis_L
            axis_distance = _distance_bound(
                np.linalg.norm(np.cross(points_W - poses[:, j, :3, 3], axis_W), axis=2), path_length
            )
            curve += amounts[place] * axis_distance * (amounts[place] + 2.0 * root_turns) / 8.0
            deviation += deviates * axis_distance
            path_length += (amounts[place] + 2.0 * deviates) * axis_distance
    base_distance = _distance_bound(np.linalg.norm(points_W - trajectory.X_WR[:, :3, 3], axis=2), path_length)
    curve += turned**2 * base_distance / 8.0
    return Paths(points_W, curve, deviation)


def _distance_bound(ends: FloatArray, path_length: FloatArray) -> FloatArray:
    """(k, m-1) bound on a distance over each interval, from its values at the states (k, m) and the way between."""
    return 0.5 * (ends[:, :-1] + ends[:, 1:] + path_length)


def _chain(robot: Robot, number: int) -> list[int]:
    """The moving joints from a link to the root."""
    links = []
    while number >= 0:
        if robot.links[number].coordinate >= 0:
            links.append(number)
        number = robot.links[number].parent
    return links


def turns(X_WR: FloatArray) -> FloatArray:
    """(m-1,) angles between successive base orientations, at most half a turn."""
    relative = np.einsum("mji,mjk->mik", X_WR[:-1, :3, :3], X_WR[1:, :3, :3])
    skew = relative - relative.transpose(0, 2, 1)
    sine = 0.5 * np.linalg.norm([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=0)
    return np.arctan2(sine, 0.5 * (np.trace(relative, axis1=1, axis2=2) - 1.0))
