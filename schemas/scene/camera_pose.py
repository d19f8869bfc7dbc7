"""A drawn camera as data: its pose in the world and its lens."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from schemas.scene.compiled import Point3, Quat_wxyz


class CameraPose(BaseModel):
    """Pose in W of a camera that looks along its -z axis, y up in the picture; vertical field of view, size in
    pixels."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    position_m: Point3
    quat_wxyz: Quat_wxyz
    fov_deg: float
    size: tuple[int, int]
