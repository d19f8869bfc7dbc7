"""Poses, headings and orientations as a program writes them, in metres and radians."""

from __future__ import annotations

import numpy as np

from geom.pose import pose
from scenec.bind.asset_library import swing_and_yaw
from scenec.ir.problem import Body
from schemas.arrays import FloatArray
from schemas.scene.geometry import Domain, FixedPose
from schemas.scene.placing import (
    DiscretePlacement,
    GridGroup,
    Group,
    Orientation,
    Placement,
    Pose,
    Ranges,
    Slot,
    SlotGroup,
    StackGroup,
)
from schemas.scene.program import Background
from source.tree import Path

FULL_TURN = 2.0 * np.pi


def orientation_of(placing: Placement | Group) -> tuple[Orientation, tuple[tuple[int, float], ...]]:
    """The orientations to prepare; for discrete poses also (number of the orientation, yaw) of each."""
    if isinstance(placing, SlotGroup | StackGroup | GridGroup):
        return "upright", ()
    if not isinstance(placing, DiscretePlacement):
        return placing.orientation, ()
    parts = [swing_and_yaw(pose.quat_wxyz or (1.0, 0.0, 0.0, 0.0)) for pose in placing.poses]
    swings = tuple(dict.fromkeys(swing for swing, _ in parts))
    yaws = [yaw if p.quat_wxyz is not None else yaw_of(p) for p, (_, yaw) in zip(placing.poses, parts, strict=True)]
    return swings, tuple((swings.index(swing), yaw) for (swing, _), yaw in zip(parts, yaws, strict=True))


def fixed_pose_of(at: Pose | Slot, stance: int, yaw_rad: float, body: Body, name: str, path: Path) -> FixedPose:
    """A fixed pose in A; without an authored `z` the thing rests on its place."""
    z = at.z if "z" in at.model_fields_set else body.resting_orientations[stance].origin_height_m
    return FixedPose(at.x, at.y, z, yaw_rad, name, path, stance)


def domain_at(fixed_poses: tuple[FixedPose, ...], path: Path) -> Domain:
    """The domain of fixed poses."""
    if not fixed_poses:
        return Domain(path=path)
    xs, ys, yaws = ([getattr(fixed_pose, key) for fixed_pose in fixed_poses] for key in ("x_m", "y_m", "yaw_rad"))
    turn = (min(yaws), max(yaws)) if max(yaws) - min(yaws) < FULL_TURN else (-np.pi, np.pi)
    orientation_indices = tuple(sorted({fixed_pose.stance for fixed_pose in fixed_poses}))
    return Domain((min(xs), max(xs)), (min(ys), max(ys)), turn, orientation_indices, fixed_poses, path)


def yaw_of(heading: Background | Pose | Slot) -> float:
    """The heading of an item, 0 where none is written."""
    return float(np.radians(heading.yaw_deg)) if heading.yaw_deg is not None else heading.yaw or 0.0


def yaw_range_of(ranges: Ranges) -> tuple[float, float]:
    """The headings that ranges allow; a whole turn where they name none."""
    low, high = ranges.yaw or (-np.pi, np.pi)
    if ranges.yaw_deg is not None:
        low, high = (float(np.radians(angle)) for angle in ranges.yaw_deg)
    return (low, high) if high - low < FULL_TURN else (-np.pi, np.pi)


def world_pose_of(background: Background | None) -> FloatArray:
    """X_WB (4, 4) of the background."""
    if background is None:
        return np.eye(4)
    c, s = np.cos(yaw_of(background)), np.sin(yaw_of(background))
    x, y, z = background.position
    least = 0.0 if background.height is None else background.height[0]  # plans raise it from there
    return pose(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), (x, y, z + least))
