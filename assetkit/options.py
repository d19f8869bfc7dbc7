"""What the user may say about a batch; part of every cache key."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

UnitName = Literal["mm", "cm", "m", "in", "auto"]
UpAxisName = Literal["x", "y", "z", "auto"]
METERS_PER_UNIT: dict[str, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}


class Options(BaseModel):
    """Statements about the assets (they become `declared` evidence) and the budgets of their processing."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    units: UnitName = "auto"
    up_axis: UpAxisName = "auto"
    role: str | None = None
    category: str | None = None
    require_category: bool = Field(default=False, description="an object of unknown category goes to a person")
    license: str | None = None
    author: str | None = None
    shell_thickness_m: float | None = Field(default=None, gt=0.0, description="wall thickness of open surfaces")
    max_triangles: int = Field(default=200_000, description="visual triangles above which a mesh is reduced")
    max_objects: int = Field(default=24, description="separate objects in one file above which a person decides")
