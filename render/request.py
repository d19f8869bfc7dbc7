"""Input of the rendering child process: one asset, its shapes, grasps and parts, and the pictures to draw."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from render.camera import STANDARD_VIEWS, CameraView
from render.drawn_grasp import DrawnGrasp
from schemas.arrays import FloatArray, IntArray
from schemas.model import Model
from schemas.physics import CollisionShape


@dataclass(frozen=True)
class RenderRequest:
    """One asset to draw: save with `schemas.files.array_files.save`, then run `python -m render REQUEST.npz`.

    model    canonical: metres, z-up, +x is the front, origin at the bottom centre.
    shapes   collision shapes in the frame of the model; none: no `collision.png`.
    out_dir  an existing folder or one to create; files of the same names are replaced.
    grasps   when there are some, only `grasps.png` is drawn: the model in grey and a gripper at each.
    parts    legend of the parts; none: no `parts.png`. `part_of` (m,) is the index of that of each triangle, counted
             through all meshes, or -1.
    size_px  edge of the square pictures; the thumbnail is always 256.
    views    camera directions; each gives the picture of its name.
    joints   draw `joints.png`, the strip of the mechanism of the model; nothing for a rigid model.
    box_m    the lowest and highest corner of the box that the pictures show; None: that of the model.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    model: Model
    shapes: tuple[CollisionShape, ...]
    out_dir: str
    size_px: int = 512
    views: tuple[CameraView, ...] = STANDARD_VIEWS
    grasps: tuple[DrawnGrasp, ...] = ()
    parts: tuple[str, ...] = ()
    part_of: IntArray | None = None
    joints: bool = False
    box_m: tuple[FloatArray, FloatArray] | None = None
