"""Input of the process that draws one mode of an object: the object, what is known of it, cameras, picture size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pydantic import ConfigDict

from render.camera import STANDARD_VIEWS, CameraView
from schemas.arrays import FloatArray, IntArray
from schemas.model import Model
from schemas.physics import CollisionShape

Mode = Literal["beauty", "wire", "parts", "collision", "physics"]
LARGEST_PX = 4096  # edge of a picture: with 2 x 2 samples a pixel 8192, which llvmpipe still draws
ROUND_ELEVATION_DEG = 20.0  # as the standard views from the sides


@dataclass(frozen=True)
class DrawnMass:
    """Mass (kg), mass centre (3,) in the asset frame, principal moments (3,) (kg m2) and axes as columns (3, 3)."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    mass_kg: float
    centre_m: FloatArray
    moments_kgm2: FloatArray
    R_AP: FloatArray


@dataclass(frozen=True)
class ModeRequest:
    """One object to draw in one mode: save with `schemas.files.array_files.save`, run `python -m render mode`.

    model    canonical: metres, z-up, +x is the front, origin at the bottom centre.
    shapes   collision shapes in the frame of the model; masses: of each moving body.
    parts    legend of the parts; `part_of` (m,) the index of that of each triangle through all meshes, or -1.
    title    first line of the sheet; `facts` the lines below it.
    out_dir  existing folder: MODE_VIEW.png for each view, MODE.png the sheet.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    mode: Mode
    model: Model
    out_dir: str
    title: str = ""
    facts: tuple[str, ...] = ()
    shapes: tuple[CollisionShape, ...] = ()
    masses: tuple[DrawnMass, ...] = ()
    parts: tuple[str, ...] = ()
    part_of: IntArray | None = None
    size_px: int = 512
    views: tuple[CameraView, ...] = STANDARD_VIEWS


def views_around(count: int) -> tuple[CameraView, ...]:
    """So many views: the four standard ones, else one every 360 / `count` degrees from the front on."""
    if count == len(STANDARD_VIEWS):
        return STANDARD_VIEWS
    turns = [360.0 * k / count for k in range(count)]
    return tuple(CameraView(f"view_{round(turn):03d}", turn, ROUND_ELEVATION_DEG) for turn in turns)
