"""Samples of a plan on disk (design 8): poses of asset frames in the world frame, metres, quaternions wxyz."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from schemas.scene.camera_pose import CameraPose
from schemas.scene.compiled import Point3, Quat_wxyz

SCHEMA_VERSION = "1.0"


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class SampledObject(_Model):
    """One object: its asset, its pose in W, its support, and the paired material (None: as authored)."""

    asset: str
    position_m: Point3
    quat_wxyz: Quat_wxyz
    support: str
    material: str | None = None


class SampledLighting(_Model):
    """A lighting and its channels as drawn; None where it leaves one alone. Temperature in K, rotation in radians."""

    id: str
    intensity: float | None = None
    exposure: float | None = None
    temperature_K: float | None = None
    rotation: float | None = None


class SceneSample(_Model):
    """One scene. `case` has the number of the case of each pool of the combination."""

    index: int = Field(ge=0)
    combination: int = Field(default=0, ge=0)
    case: tuple[int, ...]
    objects: dict[str, SampledObject]
    lighting: SampledLighting | None = None
    cameras: dict[str, CameraPose] = Field(default={}, exclude_if=lambda cameras: not cameras)
    rise_m: float = Field(
        default=0.0,
        exclude_if=lambda rise: rise == 0.0,
        description="height of the background over its lowest one; positions count it in",
    )
    background: str | None = None
    background_material: str | None = None


class SceneSamples(_Model):
    """What `mana plan sample` writes. `plan` is the SHA-256 of the plan's file."""

    schema_version: str = SCHEMA_VERSION
    plan: str
    seed: int
    samples: tuple[SceneSample, ...]
