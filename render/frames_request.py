"""Input of the process that renders a recording from one of its cameras: camera, bodies, models, lights."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from schemas.arrays import FloatArray
from schemas.model import Model
from schemas.physics import CollisionShape

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class DrawnBody:
    """A body by its shapes: number `id` in segmentations, linear RGB, X_WB (k, 4, 4), or (1, 4, 4) when static."""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    id: int
    shapes: tuple[CollisionShape, ...]
    color: Rgb
    X_WB: FloatArray


@dataclass(frozen=True)
class DrawnModel:
    """A static object with its materials; points in W."""

    id: int
    model: Model


@dataclass(frozen=True)
class FramesRequest:
    """One camera: X_WC (k, 4, 4), looking along -z with +y up, its vertical field of view and picture size.

    rows     numbers (k,) by which files are named.
    lamp     linear RGB of the lamp, 1 for the usual one; `dome` that of the light from around, turned by dome_rad.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    X_WC: FloatArray
    fovy_rad: float
    width_px: int
    height_px: int
    rows: tuple[int, ...]
    bodies: tuple[DrawnBody, ...]
    models: tuple[DrawnModel, ...]
    out_dir: str
    lamp: Rgb = (1.0, 1.0, 1.0)
    dome: Rgb = (1.0, 1.0, 1.0)
    dome_rad: float = 0.0
