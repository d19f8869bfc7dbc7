"""Cameras of a scene program: ranges of position, aim and lens, and what every drawn view must show."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from schemas.scene.written import Range, Written

Pixels = Annotated[int, Field(ge=1)]


class CameraBox(Written):
    """Where a camera may be: ranges of its position along x, y and z."""

    x: Range
    y: Range
    z: Range


class VisibleObject(Written):
    """An object of which a view shows at least `pixels` pixels, behind nothing else."""

    object: str
    pixels: Pixels


class Camera(Written):
    """A camera. Position and aim count in the world, or with `relative_to` from the origin and heading of an object."""

    id: str
    position: CameraBox
    relative_to: str | None = Field(default=None, description="node in whose frame position and point to look at are")
    look_at: str | tuple[float, float, float] = Field(description="node whose middle is aimed at, or a point")
    roll_deg: Range = Field(default=(0.0, 0.0), description="turn about the line of sight")
    fov_deg: Range = Field(description="vertical field of view")
    size: tuple[Pixels, Pixels] = Field(default=(640, 480), description="width and height of the picture, pixels")
    visible: tuple[VisibleObject, ...] = ()
